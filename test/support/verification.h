// What a verification test measured beside what it should be: asserted, and written down for the report.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <iomanip>
#include <string>

namespace deformable_sim::test {

/// The whole set (./run study verify) or the fast part of it (./run test).
inline bool verify_all() {
  const char* all = std::getenv("DEFORMABLE_SIM_VERIFY");
  return all != nullptr && std::string(all) == "all";
}

enum class Tolerance { kRelative, kAbsolute };

/// Expects |measured - expected| <= tolerance (times |expected| when relative). `row` is the row of the table of
/// yardsticks (for example "A1"), `what` the case, unit included. With DEFORMABLE_SIM_VERIFY_REPORT=FILE a line
/// row|what|expected|measured|tolerance|kind is appended.
inline void check(const std::string& row, const std::string& what, double measured, double expected, double tolerance,
                  Tolerance kind = Tolerance::kRelative) {
  const double allowed = kind == Tolerance::kRelative ? tolerance * std::abs(expected) : tolerance;
  EXPECT_LE(std::abs(measured - expected), allowed)
      << row << ", " << what << ": measured " << std::setprecision(10) << measured << ", expected " << expected;
  const char* report = std::getenv("DEFORMABLE_SIM_VERIFY_REPORT");
  if (report == nullptr) return;
  std::ofstream(report, std::ios::app) << std::setprecision(12) << row << '|' << what << '|' << expected << '|'
                                       << measured << '|' << tolerance << '|'
                                       << (kind == Tolerance::kRelative ? "relative" : "absolute") << '\n';
}

}  // namespace deformable_sim::test
