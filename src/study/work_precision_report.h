// A study of one scene, as text, tables and JSON.
#pragma once

#include <string>

#include "work_precision.h"

namespace deformable_sim::work_precision {

/// For people: the reference, the front, and the cheapest run for each error.
std::string text_of(const Result& result);
/// One line a run, the columns of row_header(), by position error; runs that diverged at the end.
std::string csv_of(const Result& result);
/// All of it; what the page is made of.
std::string json_of(const Result& result);
/// For programs that choose a solver: the scene's features, and configuration, cost and error of each run of the front.
std::string summary_of(const Result& result);

}  // namespace deformable_sim::work_precision
