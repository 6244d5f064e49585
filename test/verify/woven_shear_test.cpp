// Cloth whose yarns hardly stretch, sheared to large angles: the picture frame and the bias extension test.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "deformable_sim/core/energy/shell_terms.h"
#include "support/sheet_meshes.h"
#include "support/sheets.h"
#include "support/statics.h"
#include "support/verification.h"

namespace deformable_sim::test {
namespace {

constexpr double kShear = 50.0;  // N/m

SheetMaterial yarns(double stiffness) {
  SheetMaterial material;
  material.warp = material.weft = stiffness;
  material.shear = kShear;
  material.warp_direction = Vec3(1, 1, 0).normalized();
  return material;
}

/// Shear angle (degrees) that yarns of fixed length have when the diagonal of their net grows from L0 to L0 + delta.
double shear_angle(double l0, double delta) {
  return 90.0 - 2.0 * std::acos((l0 + delta) / (std::sqrt(2.0) * l0)) * 180.0 / M_PI;
}

/// How much the right angle between the yarns of a face has closed, in degrees.
double shear_of(const TriangleMesh& mesh, size_t face, const Nodes& x) {
  const auto& t = mesh.triangles[face];
  Eigen::Matrix2d rest, now;
  for (int k = 0; k < 2; ++k) {
    const int end = t[static_cast<size_t>(k) + 1];
    rest.col(k) = (mesh.rest.col(end) - mesh.rest.col(t[0])).head<2>();
    now.col(k) = (x.col(end) - x.col(t[0])).head<2>();
  }
  const Eigen::Matrix2d f = now * rest.inverse();
  const Eigen::Vector2d warp = f * Eigen::Vector2d(1, 1), weft = f * Eigen::Vector2d(1, -1);
  return 90.0 - std::acos(warp.dot(weft) / (warp.norm() * weft.norm())) * 180.0 / M_PI;
}

TEST(PictureFrame, ShearsTheYarnsByTheAngleOfItsHinges) {
  // Four hinged bars along the yarns, diagonal L0 + delta: shear = 90 - 2 acos((L0 + delta) / (sqrt 2 L0)) degrees, the
  // same in every face, and the stress of the yarns vanishes: F = diag(cos t, sin t) sqrt 2 keeps their lengths.
  for (const double degrees : {5.0, 20.0, 40.0, 60.0}) {
    const double half = 0.5 * (90.0 - degrees) * M_PI / 180.0;  // between a bar and the diagonal
    const TriangleMesh mesh = irregular_mesh(0.2, 0.2, 5, 5, 0.3);
    System frame(mesh.rest, Eigen::VectorXd::Ones(mesh.rest.cols()));
    frame.add(make_membrane(mesh, yarns(1e3 * kShear), 0));
    StaticSettings settings;
    settings.tolerance = 1e-10;
    settings.largest_move = 0.02;
    for (int i = 0; i < mesh.rest.cols(); ++i) {
      const Vec3 x = mesh.rest.col(i);
      frame.state.x.col(i) = std::sqrt(2.0) * Vec3(std::cos(half) * x[0], std::sin(half) * x[1], 0.0);
      if (on_border(mesh, i)) {
        frame.hold(i);
      } else {
        frame.state.x.col(i) += Vec3(2e-4 * std::sin(7.0 * i), 2e-4 * std::cos(5.0 * i), 0.0);
      }
      settings.rollers.push_back({i, 2});
    }
    EXPECT_TRUE(find_equilibrium(&frame, settings).converged);
    double worst = 0.0;
    const double expected = shear_angle(1.0, std::sqrt(2.0) * std::cos(half) - 1.0);
    for (size_t t = 0; t < mesh.triangles.size(); ++t) {
      worst = std::max(worst, std::abs(shear_of(mesh, t, frame.state.x) - expected));
    }
    EXPECT_NEAR(expected, degrees, 1e-12);
    check("C2", "picture frame, shear angle " + std::to_string(degrees) + ": largest deviation of a face, degrees",
          worst, 0.0, 1e-6, Tolerance::kAbsolute);
    // S_12 alone works: W = G (2 E_12)^2 / 2 per area, 2 E_12 = the sine of the shear angle.
    const double sine = std::sin(degrees * M_PI / 180.0);
    check("C2", "picture frame, shear angle " + std::to_string(degrees) + ": energy, J", frame.potential_energy(),
          0.5 * kShear * sine * sine * 0.04, 1e-8);
  }
}

/// A strip [0, length] x [-width / 2, width / 2] whose yarns run at 45 degrees along the edges of its faces, `cells`
/// over half the width.
TriangleMesh bias_strip(double length, double width, int cells) {
  const double h = 0.5 * width / cells;
  const int columns = static_cast<int>(std::lround(length / h));
  std::map<std::array<int, 2>, int> index;
  std::vector<Vec3> nodes;
  for (int p = 0; p <= columns; ++p) {
    for (int q = -cells; q <= cells; ++q) {
      if ((p + q) % 2 != 0) continue;
      index[{p, q}] = static_cast<int>(nodes.size());
      nodes.emplace_back(p * h, q * h, 0.0);
    }
  }
  TriangleMesh mesh;
  mesh.rest.resize(3, static_cast<Eigen::Index>(nodes.size()));
  for (size_t i = 0; i < nodes.size(); ++i) mesh.rest.col(static_cast<Eigen::Index>(i)) = nodes[i];
  const auto add = [&](std::array<int, 2> a, std::array<int, 2> b, std::array<int, 2> c) {
    if (index.count(a) && index.count(b) && index.count(c)) mesh.triangles.push_back({index[a], index[b], index[c]});
  };
  // A cell has its middle at odd p + q; on the border half of it is left.
  for (int p = 0; p <= columns; ++p) {
    for (int q = -cells; q <= cells; ++q) {
      if ((p + q) % 2 == 0) continue;
      const bool along = std::abs(q) == cells;  // halves over and under a line along the strip
      if (along) {
        add({p - 1, q}, {p + 1, q}, {p, q + 1});
        add({p + 1, q}, {p - 1, q}, {p, q - 1});
      } else {
        add({p, q - 1}, {p, q + 1}, {p - 1, q});
        add({p, q + 1}, {p, q - 1}, {p + 1, q});
      }
    }
  }
  return mesh;
}

/// Mean shear angle (degrees) along the middle line of a strip three widths long, pulled by delta, between the
/// triangles that its clamps keep stiff.
double middle_shear(double delta, double stiffness) {
  const double width = 0.1, length = 0.3;
  const TriangleMesh mesh = bias_strip(length, width, 4);
  System strip(mesh.rest, Eigen::VectorXd::Ones(mesh.rest.cols()));
  strip.add(make_membrane(mesh, yarns(stiffness), 0));
  StaticSettings settings;
  settings.tolerance = 1e-9;
  settings.iterations = 2000;
  settings.largest_move = 0.01;
  for (int i = 0; i < mesh.rest.cols(); ++i) {
    const double x = mesh.rest(0, i);
    strip.state.x(0, i) += delta * x / length;
    strip.state.x(1, i) *= 1.0 - 0.8 * delta / length;
    settings.rollers.push_back({i, 2});
    if (x > 1e-9 && x < length - 1e-9) continue;
    strip.state.x.col(i) = mesh.rest.col(i) + Vec3(x > 1e-9 ? delta : 0.0, 0.0, 0.0);
    strip.hold(i);
  }
  EXPECT_TRUE(find_equilibrium(&strip, settings).converged);
  double sum = 0.0;
  int count = 0;
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    Vec3 middle = Vec3::Zero();
    for (const int i : mesh.triangles[t]) middle += mesh.rest.col(i) / 3.0;
    if (std::abs(middle[1]) > 1e-9 || std::abs(middle[0] - 0.5 * length) > 0.5 * (length - width)) continue;
    sum += shear_of(mesh, t, strip.state.x);
    ++count;
  }
  return sum / count;
}

TEST(BiasExtension, ShearsItsMiddleByTheAngleOfYarnsOfFixedLength) {
  // Clamped at both ends: over L0 = length - width no yarn of the middle line is held, and their directions add up to
  // L0 + delta: shear = 90 - 2 acos((L0 + delta) / (sqrt 2 L0)) degrees in the mean (least in the very middle, where no
  // yarn crosses a stiff one). In the limit of stiff yarns: what they stretch is of first order in shear / stiffness,
  // two stiffnesses extrapolate. 1 %: the mean of angles is not that of their cosines.
  const double l0 = 0.2;
  for (const double share : {0.05, 0.1, 0.2}) {
    const double delta = share * l0, soft = middle_shear(delta, 1e4 * kShear),
                 stiff = middle_shear(delta, 2e4 * kShear);
    check("C2", "bias extension by " + std::to_string(share) + " of L0, shear angle in the middle, degrees",
          2.0 * stiff - soft, shear_angle(l0, delta), 0.01);
  }
}

}  // namespace
}  // namespace deformable_sim::test
