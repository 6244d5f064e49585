// Outcomes of many cases, counted.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "fuzz_run.h"

namespace deformable_sim::fuzz {

class Tally {
 public:
  /// compared: in its bits; patient: given more time before it was cut.
  void add(std::uint64_t seed, const Outcome& outcome, bool compared, bool patient);
  int failures() const;
  /// A table of ends, failures by their word, and stops by integrator.
  std::string text() const;
  /// One line a case: seed, end, what, integrator, simulated time, steps, CPU time, refused commands, detail.
  std::string csv() const;

 private:
  struct Entry {
    std::uint64_t seed;
    Outcome outcome;
    bool compared, patient;
  };
  std::vector<Entry> entries_;
};

}  // namespace deformable_sim::fuzz
