// Cusick's drapemeter.
#include <algorithm>
#include <cmath>
#include <random>

#include "cloth_bending.h"

namespace deformable_sim::study {
namespace {

constexpr double kDisc = 0.09, kCloth = 0.15;  // m, radii
constexpr double kNudge = 2e-4;                // m: a flat ring does not know where to fold

/// A ring of triangles from inside the disc's edge to the rim; the first two circles are clamped, the disc's edge lies
/// halfway between them. Node = ring * sectors + sector.
TriangleMesh ring_mesh(int rings, int sectors) {
  TriangleMesh mesh;
  const double width = (kCloth - kDisc) / (rings - 0.5);
  mesh.rest.resize(3, (rings + 1) * sectors);
  for (int r = 0; r <= rings; ++r) {
    const double radius = kDisc + (r - 0.5) * width;
    for (int s = 0; s < sectors; ++s) {
      const double angle = 2.0 * kPi * s / sectors;
      mesh.rest.col(r * sectors + s) = Vec3(radius * std::cos(angle), radius * std::sin(angle), 0.0);
    }
  }
  for (int r = 0; r < rings; ++r) {
    for (int s = 0; s < sectors; ++s) {
      const int a = r * sectors + s, b = r * sectors + (s + 1) % sectors, c = a + sectors, d = b + sectors;
      if ((r + s) % 2 == 0) {
        mesh.triangles.push_back({a, c, d});
        mesh.triangles.push_back({a, d, b});
      } else {
        mesh.triangles.push_back({a, c, b});
        mesh.triangles.push_back({c, d, b});
      }
    }
  }
  return mesh;
}

/// The triangles seen from above on a grid of squares, and what they cover.
class Shadow {
 public:
  explicit Shadow(double half) : half_(half), cover_(kPixels * kPixels, 0) {}

  void add(const Vec3& a, const Vec3& b, const Vec3& c) {
    const double area = cross(a, b, c);
    if (std::abs(area) < 1e-14) return;
    const auto range = [&](int axis) {
      const auto [low, high] = std::minmax({a[axis], b[axis], c[axis]});
      return std::array<int, 2>{pixel(low), pixel(high)};
    };
    const auto columns = range(0), rows = range(1);
    for (int row = rows[0]; row <= rows[1]; ++row) {
      for (int column = columns[0]; column <= columns[1]; ++column) {
        const Vec3 p(middle(column), middle(row), 0.0);
        const double u = cross(a, b, p) / area, v = cross(b, c, p) / area, w = cross(c, a, p) / area;
        if (u >= 0.0 && v >= 0.0 && w >= 0.0) cover_[static_cast<size_t>(row * kPixels + column)] = 1;
      }
    }
  }

  /// m^2, beyond `radius` from the middle.
  double area_beyond(double radius) const {
    int count = 0;
    for (int row = 0; row < kPixels; ++row) {
      for (int column = 0; column < kPixels; ++column) {
        const bool outside = std::hypot(middle(column), middle(row)) > radius;
        count += outside && cover_[static_cast<size_t>(row * kPixels + column)];
      }
    }
    const double side = 2.0 * half_ / kPixels;
    return count * side * side;
  }

  /// Distance of the shadow's outline from the middle, m, in a direction.
  double reach(double angle) const {
    const double step = half_ / kPixels;
    for (double r = half_ * 0.999; r > kDisc; r -= step) {
      const int column = pixel(r * std::cos(angle)), row = pixel(r * std::sin(angle));
      if (cover_[static_cast<size_t>(row * kPixels + column)]) return r;
    }
    return kDisc;
  }

 private:
  static constexpr int kPixels = 1200;
  static double cross(const Vec3& a, const Vec3& b, const Vec3& p) {
    return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
  }
  int pixel(double x) const {
    return std::clamp(static_cast<int>((x + half_) / (2.0 * half_) * kPixels), 0, kPixels - 1);
  }
  double middle(int pixel) const { return (pixel + 0.5) * 2.0 * half_ / kPixels - half_; }

  double half_;
  std::vector<char> cover_;
};

int strongest_harmonic(const std::vector<double>& outline) {
  const auto n = static_cast<double>(outline.size());
  int best = 0;
  double most = 0.0;
  for (int h = 2; h <= 20; ++h) {
    double c = 0.0, s = 0.0;
    for (size_t k = 0; k < outline.size(); ++k) {
      c += outline[k] * std::cos(2.0 * kPi * h * static_cast<double>(k) / n);
      s += outline[k] * std::sin(2.0 * kPi * h * static_cast<double>(k) / n);
    }
    if (std::hypot(c, s) > most) {
      most = std::hypot(c, s);
      best = h;
    }
  }
  return best;
}

}  // namespace

namespace {

int sectors_of(int rings) {
  return 4 * static_cast<int>(std::lround(0.5 * kPi * 0.12 * (rings - 0.5) / (kCloth - kDisc)));
}

/// Displacement of a drape at a place of the flat ring: bilinear between its nodes.
Vec3 displacement(const DrapeShape& shape, double radius, double angle) {
  const int sectors = sectors_of(shape.rings);
  const double ring = std::clamp((radius - kDisc) / (kCloth - kDisc) * (shape.rings - 0.5) + 0.5, 0.0,
                                 static_cast<double>(shape.rings) - 1e-9);
  const double sector = (angle < 0.0 ? angle + 2.0 * kPi : angle) / (2.0 * kPi) * sectors;
  const int r = static_cast<int>(ring), s = static_cast<int>(sector);
  const double u = ring - r, v = sector - s;
  const auto at = [&](int i, int j) -> Vec3 { return shape.displacement.col(i * sectors + j % sectors); };
  return (1.0 - u) * ((1.0 - v) * at(r, s) + v * at(r, s + 1)) + u * ((1.0 - v) * at(r + 1, s) + v * at(r + 1, s + 1));
}

}  // namespace

Drape drape(const FabricData& fabric, const ClothModel& model, int rings, DrapeShape* shape) {
  const int sectors = sectors_of(rings);
  const TriangleMesh mesh = ring_mesh(rings, sectors);
  Specimen cloth = make_sheet(mesh, fabric, model);
  cloth.weigh(Vec3(0, 0, -kStandardGravity), cloth.node_count());
  std::mt19937 generator(1);
  for (int i = 0; i < cloth.node_count(); ++i) {
    // mt19937's own numbers are the same everywhere; those of the distributions are not.
    const double random = static_cast<double>(generator()) / 4294967295.0 - 0.5;
    const Vec3 x = mesh.rest.col(i);
    if (i < 2 * sectors) {
      cloth.hold(i);
    } else {
      cloth.state.x(2, i) += kNudge * random;
      if (shape->rings > 0) cloth.state.x.col(i) += displacement(*shape, x.norm(), std::atan2(x[1], x[0]));
    }
  }
  StaticsSettings settings;
  settings.longest_move = 0.02;
  settings.tolerance = 1e-5;
  Drape found;
  found.settled = cloth.settle(settings).converged;
  found.nodes = cloth.node_count();
  *shape = {rings, cloth.state.x - mesh.rest};

  Shadow shadow(1.05 * kCloth);
  for (const auto& t : mesh.triangles) {
    shadow.add(cloth.state.x.col(t[0]), cloth.state.x.col(t[1]), cloth.state.x.col(t[2]));
  }
  found.coefficient = 100.0 * shadow.area_beyond(kDisc) / (kPi * (kCloth * kCloth - kDisc * kDisc));
  std::vector<double> outline;
  found.outline = {"drape, " + std::to_string(rings) + " rings", "x, m", "y, m", {}};
  for (int k = 0; k <= 360; ++k) {
    const double angle = 2.0 * kPi * k / 360, radius = shadow.reach(angle);
    if (k < 360) outline.push_back(radius);
    found.outline.points.push_back({radius * std::cos(angle), radius * std::sin(angle)});
  }
  found.folds = strongest_harmonic(outline);
  return found;
}

}  // namespace deformable_sim::study
