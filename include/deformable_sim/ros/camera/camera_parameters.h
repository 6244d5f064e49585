// ~cameras: the depth cameras of the node.
#pragma once

#include <string>
#include <vector>

#include "deformable_sim/core/camera/depth_noise.h"
#include "deformable_sim/core/camera/pinhole.h"

namespace XmlRpc {
class XmlRpcValue;
}

namespace deformable_sim {

struct CameraParameters {
  std::string name;
  std::string frame;  // tf frame, optical: x right, y down, z forward
  Pinhole pinhole;
  double rate = 10.0;  // Hz, simulated; 0 = never
  DepthNoise noise;
};

/// Of {name: {frame: ..., hfov or fx: ..., ...}}, in the order of their names. Throws InputError naming the parameter
/// and what is allowed: a key that is not known or missing, a type, a range.
std::vector<CameraParameters> to_cameras(const XmlRpc::XmlRpcValue& value);

}  // namespace deformable_sim
