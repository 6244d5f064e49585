#include "deformable_sim/core/contact/closest_points.h"

#include <algorithm>

namespace deformable_sim {
namespace {

constexpr double kParallel = 1e-12;  // sin^2 of the angle between segments that count as parallel

double clamp01(double s) {
  return std::min(1.0, std::max(0.0, s));
}

ClosestPoints on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c, double wa, double wb, double wc) {
  return {{1.0, wa, wb, wc}, p - wa * a - wb * b - wc * c};
}

/// The nearest of the three edges: for triangles without area.
ClosestPoints on_edges(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3* corner[3] = {&a, &b, &c};
  ClosestPoints best{};
  double least = -1.0;
  for (int e = 0; e < 3; ++e) {
    const Vec3 &from = *corner[e], &to = *corner[(e + 1) % 3];
    const Vec3 way = to - from;
    const double squared = way.squaredNorm();
    const double s = squared > 0.0 ? clamp01(way.dot(p - from) / squared) : 0.0;
    std::array<double, 3> w{{0.0, 0.0, 0.0}};
    w[static_cast<size_t>(e)] = 1.0 - s;
    w[static_cast<size_t>((e + 1) % 3)] = s;
    const ClosestPoints found = on_triangle(p, a, b, c, w[0], w[1], w[2]);
    if (least < 0.0 || found.apart.squaredNorm() < least) {
      least = found.apart.squaredNorm();
      best = found;
    }
  }
  return best;
}

}  // namespace

ClosestPoints closest_point_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, ac = c - a, ap = p - a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0.0 && d2 <= 0.0) return on_triangle(p, a, b, c, 1.0, 0.0, 0.0);
  const Vec3 bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0.0 && d4 <= d3) return on_triangle(p, a, b, c, 0.0, 1.0, 0.0);
  const Vec3 cp = p - c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0.0 && d5 <= d6) return on_triangle(p, a, b, c, 0.0, 0.0, 1.0);
  // Twice the areas of the triangles that p's projection makes with the edges, times twice the whole.
  const double vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
  const double whole = va + vb + vc;
  if (!(whole > 1e-14 * ab.squaredNorm() * ac.squaredNorm())) return on_edges(p, a, b, c);
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) {
    const double s = d1 / (d1 - d3);
    return on_triangle(p, a, b, c, 1.0 - s, s, 0.0);
  }
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) {
    const double s = d2 / (d2 - d6);
    return on_triangle(p, a, b, c, 1.0 - s, 0.0, s);
  }
  if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0) {
    const double s = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return on_triangle(p, a, b, c, 0.0, 1.0 - s, s);
  }
  return on_triangle(p, a, b, c, va / whole, vb / whole, vc / whole);
}

ClosestPoints closest_segment_segment(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const Vec3 u = b - a, v = d - c, w = a - c;
  const double uu = u.squaredNorm(), vv = v.squaredNorm(), uv = u.dot(v), uw = u.dot(w), vw = v.dot(w);
  double s = 0.0, t = 0.0;  // of a + s u and c + t v
  if (uu == 0.0) {
    t = vv > 0.0 ? clamp01(vw / vv) : 0.0;
  } else if (vv == 0.0) {
    s = clamp01(-uw / uu);
  } else {
    const double sine = uu * vv - uv * uv;
    if (sine > kParallel * uu * vv) {
      s = clamp01((uv * vw - uw * vv) / sine);
    } else {
      // Where c and d lie along a b, and the middle of what is common.
      const double of_c = -uw / uu, of_d = of_c + uv / uu;
      const double from = std::max(0.0, std::min(of_c, of_d)), to = std::min(1.0, std::max(of_c, of_d));
      s = clamp01(0.5 * (from + to));
    }
    t = (uv * s + vw) / vv;
    if (t < 0.0 || t > 1.0) {
      t = clamp01(t);
      s = clamp01((uv * t - uw) / uu);
    }
  }
  return {{1.0 - s, s, 1.0 - t, t}, w + s * u - t * v};
}

}  // namespace deformable_sim
