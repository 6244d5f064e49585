#include "peer_scene.h"

#include <cmath>
#include <fstream>
#include <iomanip>
#include <limits>
#include <sstream>
#include <stdexcept>

namespace peers {
namespace {

constexpr double kHeld = 1e-5;      // m, rounding of positions in single precision
constexpr double kDiverged = 10.0;  // m, an error that no motion of bodies of 1 m has in a second

bool holds(const Scene& scene, const Outcome& outcome) {
  for (size_t k = 0; k < scene.nodes.size(); ++k) {
    if (scene.nodes[k].held && !(rms_distance({scene.nodes[k].x}, {outcome.x[k]}) < kHeld)) return false;
  }
  return true;
}

}  // namespace

void write_scene(const Scene& scene, const std::string& path) {
  std::ofstream out(path);
  out << std::setprecision(17) << scene.name << '\n'
      << scene.seconds << ' ' << scene.drag << ' ' << scene.gravity << '\n'
      << scene.nodes.size() << ' ' << scene.links.size() << '\n';
  for (const Node& n : scene.nodes)
    out << n.x[0] << ' ' << n.x[1] << ' ' << n.x[2] << ' ' << n.mass << ' ' << n.held << '\n';
  for (const Link& l : scene.links) out << l.a << ' ' << l.b << ' ' << l.rest << ' ' << l.stiffness << '\n';
  for (const Point& p : scene.solution) out << p[0] << ' ' << p[1] << ' ' << p[2] << '\n';
  if (!out) throw std::runtime_error("cannot write " + path);
}

Scene read_scene(const std::string& path) {
  std::ifstream in(path);
  Scene scene;
  size_t nodes = 0, links = 0;
  in >> scene.name >> scene.seconds >> scene.drag >> scene.gravity >> nodes >> links;
  if (!in) throw std::runtime_error(path + " is no scene");
  scene.nodes.resize(nodes);
  scene.links.resize(links);
  scene.solution.resize(nodes);
  for (Node& n : scene.nodes) in >> n.x[0] >> n.x[1] >> n.x[2] >> n.mass >> n.held;
  for (Link& l : scene.links) in >> l.a >> l.b >> l.rest >> l.stiffness;
  for (Point& p : scene.solution) in >> p[0] >> p[1] >> p[2];
  if (!in) throw std::runtime_error(path + " ends too early");
  return scene;
}

double total_mass(const Scene& scene) {
  double sum = 0.0;
  for (const Node& n : scene.nodes) sum += n.mass;
  return sum;
}

double rms_distance(const std::vector<Point>& a, const std::vector<Point>& b) {
  double sum = 0.0;
  for (size_t k = 0; k < a.size(); ++k) {
    for (size_t c = 0; c < 3; ++c) sum += (a[k][c] - b[k][c]) * (a[k][c] - b[k][c]);
  }
  return std::isfinite(sum) ? std::sqrt(sum / static_cast<double>(a.size())) : std::numeric_limits<double>::infinity();
}

std::string json_line(const Scene& scene, const Outcome& outcome) {
  const double error = rms_distance(outcome.x, scene.solution);
  const bool diverged = !(error < kDiverged);
  const char* status = !outcome.finished ? "stopped" : diverged ? "diverged" : holds(scene, outcome) ? "done" : "lost";
  std::ostringstream out;
  out << std::setprecision(6) << "{\"error_mm\": " << (diverged ? -1.0 : 1e3 * error)
      << ", \"cpu_per_s\": " << outcome.cpu_seconds / scene.seconds << ", \"status\": \"" << status
      << "\", \"detail\": \"" << outcome.detail << "\"}";
  return out.str();
}

}  // namespace peers
