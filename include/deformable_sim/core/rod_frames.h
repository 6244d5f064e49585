// Material frames of the segments of rods: how they start, are carried along, and are read.
#pragma once

#include "deformable_sim/core/model.h"
#include "deformable_sim/core/state.h"

namespace deformable_sim {

/// Reference directors of one rod, carried from segment to segment without twist.
struct RodFrames {
  Nodes directors, tangents;         // 3 x segments
  Eigen::VectorXd reference_twists;  // rad, 1 x segments: zero but for the joint that closes a loop
};

/// `first` is made normal to the first tangent; zero, or along it: any normal.
RodFrames rod_frames(const Polyline& line, const Vec3& first);

/// Carries the frames of the segments [first, first + count) to the positions of the nodes first_node + i, without
/// spin; angles stay. The same to the last bit where nothing has moved.
void carry_frames(int first_segment, int segment_count, int first_node, bool closed, State* s);

/// One column a segment of this rod, to put back with set_rod_state().
RodState rod_state(const Model& model, const Body& body, const State& s);
/// Throws InputError for a wrong size, numbers that are not finite, and directors that are not unit vectors normal to
/// the segments between the nodes x (3 x node_count).
void check_rod_state(const Body& body, const Nodes& x, const RodState& rod);
/// At the positions the state has. Restores what rod_state() read at the same positions to the last bit.
void set_rod_state(const Model& model, const Body& body, const RodState& rod, State* s);

/// Rotation whose columns are the first and second material director and the tangent of segment `segment` (counted from
/// the body's first) of a rod with twist, at the end of a step.
Mat3 material_frame(const Model& model, const Body& body, const State& s, int segment);

/// The angle of that segment, rad, unwrapped, and its rate, rad/s.
double segment_angle(const Model& model, const Body& body, const Nodes& x, int segment);

}  // namespace deformable_sim
