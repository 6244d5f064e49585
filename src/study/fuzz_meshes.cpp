// Meshes that scenes made at random name. All are about a metre across: scenes scale them.
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "deformable_sim/core/error.h"
#include "fuzz_random.h"
#include "fuzz_scene.h"

namespace deformable_sim::fuzz {
namespace {

using Point = std::array<double, 3>;

struct Surface {
  std::vector<Point> points;
  std::vector<std::array<int, 3>> faces;

  std::string obj() const {
    std::string text;
    for (const Point& p : points)
      text += "v " + number_text(p[0]) + " " + number_text(p[1]) + " " + number_text(p[2]) + "\n";
    for (const auto& f : faces) {
      text += "f";
      for (const int node : f) text += " " + std::to_string(node + 1);
      text += "\n";
    }
    return text;
  }
};

/// Points at (x_i, y_j), each cell cut along one of its diagonals.
Surface sheet(const std::vector<double>& x, const std::vector<double>& y, double jitter, std::uint64_t seed) {
  Random r(seed);
  Surface s;
  const auto columns = static_cast<int>(x.size());
  for (const double v : y) {
    for (const double u : x) s.points.push_back({u + r.uniform(-jitter, jitter), v + r.uniform(-jitter, jitter), 0.0});
  }
  for (int j = 0; j + 1 < static_cast<int>(y.size()); ++j) {
    for (int i = 0; i + 1 < columns; ++i) {
      const int a = j * columns + i, b = a + 1, c = b + columns, d = a + columns;
      if (r.chance(0.5)) {
        s.faces.push_back({a, b, c});
        s.faces.push_back({a, c, d});
      } else {
        s.faces.push_back({a, b, d});
        s.faces.push_back({b, c, d});
      }
    }
  }
  return s;
}

std::vector<double> even(int cells) {
  std::vector<double> x;
  for (int k = 0; k <= cells; ++k) x.push_back(static_cast<double>(k) / cells - 0.5);
  return x;
}

/// Half a metre to either side, each cell 1.7 times as wide as the one before.
std::vector<double> growing(int cells) {
  std::vector<double> x{0.0};
  for (int k = 0; k < cells; ++k) x.push_back(x.back() + std::pow(1.7, k));
  const double all = x.back();
  for (double& value : x) value = value / all - 0.5;
  return x;
}

/// A sheet on a sphere of radius 0.6.
Surface cap() {
  Surface s = sheet(even(6), even(6), 0.02, 3);
  for (Point& p : s.points) p[2] = std::sqrt(0.9 - p[0] * p[0] - p[1] * p[1]) - 0.6;
  return s;
}

/// A prism over a polygon, counterclockwise, cut into the given triangles.
Surface prism(const std::vector<std::array<double, 2>>& outline, const std::vector<std::array<int, 3>>& cut,
              double half) {
  Surface s;
  const auto n = static_cast<int>(outline.size());
  for (const double z : {-half, half})
    for (const auto& p : outline) s.points.push_back({p[0], p[1], z});
  for (const auto& t : cut) {
    s.faces.push_back({t[0], t[2], t[1]});
    s.faces.push_back({t[0] + n, t[1] + n, t[2] + n});
  }
  for (int k = 0; k < n; ++k) {
    const int next = (k + 1) % n;
    s.faces.push_back({k, next, next + n});
    s.faces.push_back({k, next + n, k + n});
  }
  return s;
}

Surface octahedron() {
  Surface s;
  s.points = {{0.5, 0, 0}, {-0.5, 0, 0}, {0, 0.5, 0}, {0, -0.5, 0}, {0, 0, 0.5}, {0, 0, -0.5}};
  s.faces = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  return s;
}

/// A box of cells, each cut into six tetrahedra around its diagonal, nodes moved by up to `jitter` of a cell; MEDIT.
std::string block(const std::array<int, 3>& cells, const Point& size, double jitter, std::uint64_t seed) {
  Random r(seed);
  std::string nodes, tets;
  const std::array<int, 3> n{cells[0] + 1, cells[1] + 1, cells[2] + 1};
  for (int k = 0; k < n[2]; ++k)
    for (int j = 0; j < n[1]; ++j)
      for (int i = 0; i < n[0]; ++i) {
        const std::array<int, 3> at{i, j, k};
        for (size_t a = 0; a < 3; ++a) {
          const double place = (at[a] + r.uniform(-jitter, jitter)) / cells[a] - 0.5;
          nodes += number_text(size[a] * place) + " ";
        }
        nodes += "0\n";
      }
  const std::array<std::array<size_t, 3>, 6> orders{
      {{{0, 1, 2}}, {{1, 2, 0}}, {{2, 0, 1}}, {{0, 2, 1}}, {{1, 0, 2}}, {{2, 1, 0}}}};
  const auto number = [&n](const std::array<int, 3>& p) { return p[0] + n[0] * (p[1] + n[1] * p[2]) + 1; };
  for (int k = 0; k < cells[2]; ++k)
    for (int j = 0; j < cells[1]; ++j)
      for (int i = 0; i < cells[0]; ++i)
        for (size_t o = 0; o < orders.size(); ++o) {
          std::array<int, 3> p{i, j, k};
          std::array<int, 4> t{number(p), 0, 0, 0};
          for (size_t a = 0; a < 3; ++a) {
            ++p[orders[o][a]];
            t[a + 1] = number(p);
          }
          if (o >= 3) std::swap(t[1], t[2]);
          for (const int node : t) tets += std::to_string(node) + " ";
          tets += "0\n";
        }
  return "MeshVersionFormatted 1\nDimension 3\nVertices\n" + std::to_string(n[0] * n[1] * n[2]) + "\n" + nodes +
         "Tetrahedra\n" + std::to_string(6 * cells[0] * cells[1] * cells[2]) + "\n" + tets + "End\n";
}

}  // namespace

std::vector<std::pair<std::string, std::string>> meshes() {
  const Surface ell = prism({{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.0}, {0.0, 0.0}, {0.0, 0.5}, {-0.5, 0.5}},
                            {{0, 1, 2}, {0, 2, 3}, {0, 3, 5}, {3, 4, 5}}, 0.25);
  const Surface plate = prism({{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}}, {{0, 1, 2}, {0, 2, 3}}, 0.001);
  return {{"meshes/sheet_uneven.obj", sheet(even(9), even(9), 0.035, 1).obj()},
          {"meshes/sheet_slivers.obj", sheet(growing(10), even(3), 0.0, 2).obj()},
          {"meshes/cap.obj", cap().obj()},
          {"meshes/ell.obj", ell.obj()},
          {"meshes/octahedron.obj", octahedron().obj()},
          {"meshes/plate.obj", plate.obj()},
          {"meshes/block.mesh", block({3, 3, 3}, {1, 0.8, 0.6}, 0.1, 4)},
          {"meshes/slivers.mesh", block({6, 2, 1}, {1, 0.3, 0.005}, 0.1, 5)}};
}

void write_meshes(const std::string& dir) {
  namespace fs = std::filesystem;
  std::error_code error;
  fs::create_directories(fs::path(dir) / "meshes", error);
  for (const auto& [path, text] : meshes()) {
    std::ofstream stream(fs::path(dir) / path);
    stream << text;
    if (!stream.flush()) throw InputError("cannot write " + (fs::path(dir) / path).string());
  }
}

}  // namespace deformable_sim::fuzz
