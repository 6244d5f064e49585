// Frames of a run as files: every node's position and velocity at full precision.
#pragma once

#include <fstream>
#include <string>

#include "deformable_sim/core/snapshot.h"

namespace deformable_sim {

enum class FrameFormat { kCsv, kPly, kObj };

/// Throws InputError listing the formats.
FrameFormat frame_format(const std::string& name);

/// Writes one file per body and frame, DIR/BODY_NNNNNN.EXT, and DIR/frames.csv (frame, time in s). Numbers carry 17
/// significant digits, so that reading them back gives the same bits.
///   csv  node,x,y,z,vx,vy,vz
///   ply  ascii; vertex properties x y z vx vy vz (double), faces (cloth) or edges (rope)
///   obj  v lines, f (cloth) or l (rope) lines; velocities, which OBJ does not know, as comments "#v vx vy vz" in the
///   same order
class FrameWriter {
 public:
  /// Creates the folder. Throws InputError when it cannot be written to.
  FrameWriter(const std::string& dir, FrameFormat format);
  /// Throws std::runtime_error when the disk refuses.
  void write(const Snapshot& snapshot);
  int frames() const { return frames_; }

 private:
  std::string dir_;
  FrameFormat format_;
  std::ofstream index_;
  int frames_ = 0;
};

/// The text of one body in one frame.
std::string frame_text(const Body& body, const Nodes& x, const Nodes& v, FrameFormat format);

}  // namespace deformable_sim
