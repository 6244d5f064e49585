// What every simulator of the comparison is given: point masses, springs, what is held, and where it should all end.
#pragma once

#include <array>
#include <string>
#include <vector>

namespace peers {

using Point = std::array<double, 3>;

struct Node {
  Point x{};          // m, at the start, at rest
  double mass = 0.0;  // kg
  bool held = false;
};

/// f = stiffness (|x_b - x_a| - rest) along the link, in tension and in compression.
struct Link {
  int a = 0, b = 0;
  double rest = 0.0;       // m
  double stiffness = 0.0;  // N/m
};

struct Scene {
  std::string name;
  double seconds = 0.0;  // simulated
  double drag = 0.0;     // 1/s, force -drag m v on every node
  double gravity = 0.0;  // m/s^2, along -z
  std::vector<Node> nodes;
  std::vector<Link> links;
  std::vector<Point> solution;  // m, positions at `seconds`, converged
};

/// Throw std::runtime_error naming the file.
void write_scene(const Scene& scene, const std::string& path);
Scene read_scene(const std::string& path);

double total_mass(const Scene& scene);

/// Root mean square distance of the nodes, m; infinite where a position is not finite.
double rms_distance(const std::vector<Point>& a, const std::vector<Point>& b);

/// One run of one setting.
struct Outcome {
  std::vector<Point> x;      // m, at the end
  double cpu_seconds = 0.0;  // of the stepping thread, stepping alone
  bool finished = true;      // false: stopped by the limit of time, or a step failed
  std::string detail;        // what was done, for the record
};

/// {"error_mm": ..., "cpu_per_s": ..., "status": ..., "detail": "..."}, the status being
/// done, stopped (see Outcome::finished), diverged, or lost: a held node is not where it was held.
std::string json_line(const Scene& scene, const Outcome& outcome);

}  // namespace peers
