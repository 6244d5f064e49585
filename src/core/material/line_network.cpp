// Lines as spring networks: springs in series, EA / l each.
#include <cmath>
#include <string>

#include "deformable_sim/core/error.h"
#include "deformable_sim/core/material/spring_network.h"

namespace deformable_sim {
namespace {

constexpr double kDefaultBend = 0.01;  // bend springs, as a fraction of a segment's stiffness

void check(const LineStiffness& s) {
  const auto refuse = [](const std::string& what, double value, const std::string& allowed) {
    throw InputError(what + " is " + std::to_string(value) + "; it must be " + allowed);
  };
  const auto bad = [](double value) { return !(value >= 0.0) || !std::isfinite(value); };
  if (s.stretch && (bad(*s.stretch) || *s.stretch == 0.0)) refuse("stretch", *s.stretch, "finite and > 0 (N/m)");
  if (!s.stretch && (bad(s.axial) || s.axial == 0.0)) refuse("axial", s.axial, "finite and > 0 (N)");
  if (s.bend && bad(*s.bend)) refuse("bend", *s.bend, "finite and >= 0 (N/m)");
  if (bad(s.damping_time)) refuse("damping_time", s.damping_time, "finite and >= 0 (s)");
}

}  // namespace

SpringNetwork line_network(const Polyline& line, const LineStiffness& stiffness) {
  check(stiffness);
  const int n = static_cast<int>(line.rest.cols()), segments = line.segment_count();
  const auto length = [&](int a, int b) { return (line.rest.col(b) - line.rest.col(a)).norm(); };
  const double mean_length = [&] {
    double sum = 0.0;
    for (int k = 0; k < segments; ++k) sum += length(line.segment(k)[0], line.segment(k)[1]);
    return sum / segments;
  }();
  const double typical = stiffness.stretch ? *stiffness.stretch : stiffness.axial / mean_length;
  const double bend = stiffness.bend ? *stiffness.bend : kDefaultBend * typical;
  const int bends = bend == 0.0 ? 0 : line.closed ? (n > 4 ? n : 0) : n - 2;  // in a small ring they would coincide

  SpringNetwork network;
  for (int k = 0; k < segments; ++k) {
    const auto [a, b] = line.segment(k);
    double k_segment = stiffness.stretch ? *stiffness.stretch : stiffness.axial / length(a, b);
    if (!stiffness.stretch) {
      // Each bend spring spans two segments and pulls twice as far: it carries part of the tension.
      const int crossing = bends == 0 ? 0 : line.closed ? 2 : (k > 0 ? 1 : 0) + (k + 1 < segments ? 1 : 0);
      k_segment -= 2.0 * bend * crossing;
    }
    if (!(k_segment > 0.0)) {
      throw InputError("bend springs (" + std::to_string(bend) + " N/m) alone are stiffer than the line, EA = " +
                       std::to_string(stiffness.axial) + " N; lower them");
    }
    network.stretch.push_back({a, b, length(a, b), k_segment, stiffness.damping_time * k_segment});
  }
  for (int k = 0; k < bends; ++k) {
    const int a = k, b = (k + 2) % n;
    network.bend.push_back({a, b, length(a, b), bend, stiffness.damping_time * bend});
  }
  return network;
}

Eigen::VectorXd line_masses(const Polyline& line, double linear_density) {
  Eigen::VectorXd mass = Eigen::VectorXd::Zero(line.rest.cols());
  for (int k = 0; k < line.segment_count(); ++k) {
    const auto [a, b] = line.segment(k);
    const double half = 0.5 * linear_density * (line.rest.col(b) - line.rest.col(a)).norm();
    mass[a] += half;
    mass[b] += half;
  }
  return mass;
}

}  // namespace deformable_sim
