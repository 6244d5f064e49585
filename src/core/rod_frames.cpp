#include "deformable_sim/core/rod_frames.h"

#include <cmath>
#include <string>

#include "deformable_sim/core/element/rod_frame.h"
#include "deformable_sim/core/error.h"

namespace deformable_sim {

RodFrames rod_frames(const Polyline& line, const Vec3& first) {
  const Eigen::Index count = line.segment_count();
  RodFrames frames{Nodes(3, count), Nodes(3, count), Eigen::VectorXd::Zero(count)};
  for (Eigen::Index k = 0; k < count; ++k) {
    const auto [a, b] = line.segment(static_cast<int>(k));
    frames.tangents.col(k) = (line.rest.col(b) - line.rest.col(a)).normalized();
  }
  const Vec3 t = frames.tangents.col(0);
  const Vec3 across = first - t.dot(first) * t;
  frames.directors.col(0) =
      across.norm() > 1e-6 * first.norm() && !first.isZero(0.0) ? Vec3(across.normalized()) : any_normal(t);
  for (Eigen::Index k = 1; k < count; ++k) {
    frames.directors.col(k) =
        transported(frames.directors.col(k - 1), frames.tangents.col(k - 1), frames.tangents.col(k));
  }
  if (line.closed) {
    const Vec3 t_end = frames.tangents.col(count - 1);
    frames.reference_twists[count - 1] =
        angle_about(t, transported(frames.directors.col(count - 1), t_end, t), frames.directors.col(0));
  }
  return frames;
}

void carry_frames(int first_segment, int segment_count, int first_node, bool closed, State* s) {
  const int node_count = segment_count + (closed ? 0 : 1);
  for (int k = 0; k < segment_count; ++k) {
    const Vec3 edge = s->x.col(first_node + (k + 1) % node_count) - s->x.col(first_node + k);
    const Vec3 before = s->tangents.col(first_segment + k);
    const Vec3 tangent = RodSegment(edge, before).tangent;
    if (tangent == before) continue;
    Vec3 director = transported(s->directors.col(first_segment + k), before, tangent);
    // Round-off would otherwise add up over the steps.
    director -= tangent.dot(director) * tangent;
    s->directors.col(first_segment + k) = director.normalized();
    s->tangents.col(first_segment + k) = tangent;
  }
  for (int k = 0; k + (closed ? 0 : 1) < segment_count; ++k) {
    const int a = first_segment + k, b = first_segment + (k + 1) % segment_count;
    const Vec3 t_a = s->tangents.col(a), t_b = s->tangents.col(b);
    s->reference_twists[a] = unwrapped(
        angle_about(t_b, transported(s->directors.col(a), t_a, t_b), s->directors.col(b)), s->reference_twists[a]);
  }
}

RodState rod_state(const Model& model, const Body& body, const State& s) {
  const int count = body.line->segment_count(), first = body.first_segment;
  RodState rod(6, count);
  rod.row(0) = s.x.block(0, model.point_count() + first, 1, count);
  rod.row(1) = s.v.block(0, model.point_count() + first, 1, count);
  rod.middleRows<3>(2) = s.directors.middleCols(first, count);
  rod.row(5) = s.reference_twists.segment(first, count).transpose();
  return rod;
}

void check_rod_state(const Body& body, const Nodes& x, const RodState& rod) {
  const std::string who = "the state of the segments of '" + body.name + "' ";
  const int count = body.first_segment < 0 ? 0 : body.line->segment_count();
  if (rod.cols() != count)
    throw InputError(who + "must be 6 numbers for each of " + std::to_string(count) + " segments, or none");
  if (!rod.allFinite() || rod.cwiseAbs().maxCoeff() > 1e6) throw InputError(who + "must be finite and within 1e6");
  for (int k = 0; k < count; ++k) {
    const auto [a, b] = body.line->segment(k);
    const Vec3 director = rod.block<3, 1>(2, k);
    const Vec3 tangent = RodSegment(x.col(b) - x.col(a), Vec3::Zero()).tangent;
    if (std::abs(director.norm() - 1.0) > 1e-6 || std::abs(director.dot(tangent)) > 1e-6)
      throw InputError(who + "must have unit directors normal to the segments; segment " + std::to_string(k) +
                       " has not");
  }
}

void set_rod_state(const Model& model, const Body& body, const RodState& rod, State* s) {
  const int count = body.line->segment_count(), first = body.first_segment;
  s->x.block(0, model.point_count() + first, 1, count) = rod.row(0);
  s->v.block(0, model.point_count() + first, 1, count) = rod.row(1);
  for (int k = 0; k < count; ++k) {
    const auto [a, b] = body.line->segment(k);
    const Vec3 edge = s->x.col(body.first_node + b) - s->x.col(body.first_node + a);
    s->tangents.col(first + k) = RodSegment(edge, s->tangents.col(first + k)).tangent;
  }
  s->directors.middleCols(first, count) = rod.middleRows<3>(2);
  s->reference_twists.segment(first, count) = rod.row(5).transpose();
}

double segment_angle(const Model& model, const Body& body, const Nodes& x, int segment) {
  return x(0, model.point_count() + body.first_segment + segment) / body.radius_of_gyration;
}

Mat3 material_frame(const Model& model, const Body& body, const State& s, int segment) {
  const Vec3 t = s.tangents.col(body.first_segment + segment), u = s.directors.col(body.first_segment + segment);
  const double angle = segment_angle(model, body, s.x, segment);
  Mat3 frame;
  frame.col(0) = std::cos(angle) * u + std::sin(angle) * t.cross(u);
  frame.col(1) = t.cross(frame.col(0));
  frame.col(2) = t;
  return frame;
}

}  // namespace deformable_sim
