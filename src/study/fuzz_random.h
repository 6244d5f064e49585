// Draws for scenes made at random: the same on every machine, which the distributions of <random> are not.
#pragma once

#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <vector>

namespace deformable_sim::fuzz {

/// A sequence of draws, fixed by its seed [Steele, Lea, Flood 2014: SplitMix64].
class Random {
 public:
  /// Sequences of neighbouring seeds have nothing to do with one another: the state is a draw, not the seed.
  explicit Random(std::uint64_t seed) : state_(seed) { state_ = bits() ^ (seed << 32); }

  std::uint64_t bits() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15ULL);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return z ^ (z >> 31);
  }
  /// low <= draw < high
  double uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(bits() >> 11) / 9007199254740992.0;
  }
  /// The logarithm is uniform; low > 0.
  double decades(double low, double high) { return low * std::pow(high / low, uniform(0.0, 1.0)); }
  int whole(int low, int high) { return low + static_cast<int>(bits() % static_cast<std::uint64_t>(high - low + 1)); }
  bool chance(double p) { return uniform(0.0, 1.0) < p; }
  std::string pick(const std::vector<std::string>& words) {
    return words[static_cast<std::size_t>(whole(0, static_cast<int>(words.size()) - 1))];
  }

 private:
  std::uint64_t state_;
};

}  // namespace deformable_sim::fuzz
