#include "deformable_sim/core/camera/shape_rays.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace deformable_sim {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr RayInterval kAlways{-kInfinity, kInfinity};

RayInterval both(const RayInterval& a, const RayInterval& b) {
  return {std::max(a.enter, b.enter), std::min(a.leave, b.leave)};
}

/// Of parts whose union is convex.
RayInterval either(const RayInterval& a, const RayInterval& b) {
  if (a.empty()) return b;
  if (b.empty()) return a;
  return {std::min(a.enter, b.enter), std::max(a.leave, b.leave)};
}

/// low <= o + t d <= high.
RayInterval slab(double o, double d, double low, double high) {
  if (d == 0.0) return o >= low && o <= high ? kAlways : RayInterval();
  const double t0 = (low - o) / d, t1 = (high - o) / d;
  return {std::min(t0, t1), std::max(t0, t1)};
}

/// Roots t0 <= t1 of a t^2 + 2 b t + c = 0, a > 0 or a < 0, without cancellation. False when there are none.
bool roots(double a, double b, double c, std::pair<double, double>* t) {
  const double discriminant = b * b - a * c;
  if (!(discriminant >= 0.0)) return false;
  const double q = -(b + std::copysign(std::sqrt(discriminant), b));
  const double t0 = q / a, t1 = q == 0.0 ? 0.0 : c / q;
  *t = std::minmax(t0, t1);
  return true;
}

/// a t^2 + 2 b t + c <= 0, a >= 0.
RayInterval not_above_zero(double a, double b, double c) {
  if (a == 0.0) return c <= 0.0 ? kAlways : RayInterval();  // b is 0 with it: the ray runs along the axis
  std::pair<double, double> t;
  if (!roots(a, b, c, &t)) return {};
  return {t.first, t.second};
}

RayInterval inside_sphere(const Vec3& o, const Vec3& d, double radius) {
  return not_above_zero(d.squaredNorm(), o.dot(d), o.squaredNorm() - radius * radius);
}

RayInterval inside_cylinder(const Vec3& o, const Vec3& d, double radius, double length) {
  const RayInterval round = not_above_zero(d.head<2>().squaredNorm(), o.head<2>().dot(d.head<2>()),
                                           o.head<2>().squaredNorm() - radius * radius);
  return both(round, slab(o.z(), d.z(), -0.5 * length, 0.5 * length));
}

/// x^2 + y^2 <= k^2 (tip - z)^2 between base and tip. A ray steeper than the side is outside the double cone between
/// two roots, not inside: it is inside this half of it before the first or after the second.
RayInterval inside_cone(const Vec3& o, const Vec3& d, double radius, double length) {
  const double k = radius / length, below = 0.5 * length - o.z();
  const double a = d.head<2>().squaredNorm() - k * k * d.z() * d.z();
  const double b = o.head<2>().dot(d.head<2>()) + k * k * below * d.z();
  const double c = o.head<2>().squaredNorm() - k * k * below * below;
  const RayInterval between = slab(o.z(), d.z(), -0.5 * length, 0.5 * length);
  std::pair<double, double> t;
  if (std::abs(a) < 1e-14 * d.squaredNorm()) {  // along the side: linear
    if (b == 0.0) return c <= 0.0 ? between : RayInterval();
    const double root = -0.5 * c / b;
    return both(between, b > 0.0 ? RayInterval{-kInfinity, root} : RayInterval{root, kInfinity});
  }
  if (a > 0.0) return both(between, not_above_zero(a, b, c));
  if (!roots(a, b, c, &t)) return between;
  const RayInterval before = both(between, {-kInfinity, t.first}), after = both(between, {t.second, kInfinity});
  if (before.empty()) return after;
  if (after.empty()) return before;
  return before.leave - before.enter > after.leave - after.enter ? before : after;  // one of them is the tip alone
}

}  // namespace

RayInterval inside(const Shape& shape, const Vec3& o, const Vec3& d) {
  const double radius = shape.size.x(), length = shape.size.y();
  switch (shape.type) {
    case Shape::Type::kBox: {
      RayInterval all = kAlways;
      for (int axis = 0; axis < 3; ++axis) {
        all = both(all, slab(o[axis], d[axis], -0.5 * shape.size[axis], 0.5 * shape.size[axis]));
      }
      return all;
    }
    case Shape::Type::kSphere:
      return inside_sphere(o, d, radius);
    case Shape::Type::kCylinder:
      return inside_cylinder(o, d, radius, length);
    case Shape::Type::kCapsule: {
      const Vec3 end(0, 0, 0.5 * length);
      return either(inside_cylinder(o, d, radius, length),
                    either(inside_sphere(o - end, d, radius), inside_sphere(o + end, d, radius)));
    }
    case Shape::Type::kCone:
      return inside_cone(o, d, radius, length);
    case Shape::Type::kPlane:
    case Shape::Type::kMesh:
    case Shape::Type::kVoxels:
      break;
  }
  return {};
}

Vec3 half_extents(const Shape& shape) {
  const double radius = shape.size.x(), half_length = 0.5 * shape.size.y();
  switch (shape.type) {
    case Shape::Type::kBox:
      return 0.5 * shape.size;
    case Shape::Type::kSphere:
      return Vec3::Constant(radius);
    case Shape::Type::kCapsule:
      return {radius, radius, half_length + radius};
    case Shape::Type::kCylinder:
    case Shape::Type::kCone:
      return {radius, radius, half_length};
    case Shape::Type::kPlane:
    case Shape::Type::kMesh:
    case Shape::Type::kVoxels:
      break;
  }
  return Vec3::Zero();
}

}  // namespace deformable_sim
