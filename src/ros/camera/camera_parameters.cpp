#include "deformable_sim/ros/camera/camera_parameters.h"

#include <cmath>
#include <set>
#include <sstream>

#include <xmlrpcpp/XmlRpcValue.h>

#include "deformable_sim/core/error.h"
#include "deformable_sim/ros/convert.h"

namespace deformable_sim {

namespace {

using XmlRpc::XmlRpcValue;

constexpr int kMostPixels = 4096;    // along one side
constexpr double kMostFocal = 1e5;   // pixels
constexpr double kWidestView = 3.0;  // rad

[[noreturn]] void refuse(const std::string& path, const std::string& why) {
  throw InputError("parameter ~" + path + ": " + why);
}

/// One struct of parameters; every key that is read is known.
class Struct {
 public:
  Struct(const XmlRpcValue& value, std::string path) : value_(value), path_(std::move(path)) {
    if (value.getType() != XmlRpcValue::TypeStruct) refuse(path_, "keys and values are needed");
  }

  const XmlRpcValue* find(const char* key) {
    known_.insert(key);
    for (const auto& [name, member] : value_) {
      if (name == key) return &member;
    }
    return nullptr;
  }

  std::string path_of(const std::string& key) const { return path_ + "/" + printable(key); }

  void read(const char* key, std::string* value) {
    const XmlRpcValue* raw = find(key);
    if (!raw) return;
    if (raw->getType() != XmlRpcValue::TypeString) refuse(path_of(key), "a string is needed");
    *value = static_cast<const std::string&>(*raw);
  }

  void read(const char* key, int low, int high, int* value) {
    const XmlRpcValue* raw = find(key);
    if (!raw) return;
    const std::string allowed = std::to_string(low) + " ... " + std::to_string(high);
    if (raw->getType() != XmlRpcValue::TypeInt) refuse(path_of(key), "a whole number is needed, " + allowed);
    const int number = static_cast<const int&>(*raw);
    if (number < low || number > high) {
      refuse(path_of(key), std::to_string(number) + " is out of range, allowed is " + allowed);
    }
    *value = number;
  }

  /// Returns whether it is there.
  bool read_real(const char* key, double low, double high, double* value) {
    const XmlRpcValue* raw = find(key);
    if (!raw) return false;
    std::ostringstream allowed;
    allowed << low << " ... " << high;
    double number = 0.0;
    if (raw->getType() == XmlRpcValue::TypeDouble) {
      number = static_cast<const double&>(*raw);
    } else if (raw->getType() == XmlRpcValue::TypeInt) {
      number = static_cast<const int&>(*raw);
    } else {
      refuse(path_of(key), "a number is needed, " + allowed.str());
    }
    if (!(number >= low && number <= high)) refuse(path_of(key), "out of range, allowed is " + allowed.str());
    *value = number;
    return true;
  }

  /// After all were read: typing mistakes are refused.
  void check_keys() const {
    for (const auto& [name, member] : value_) {
      if (known_.count(name) > 0) continue;
      std::string list;
      for (const std::string& key : known_) list += (list.empty() ? "" : ", ") + key;
      refuse(path_of(name), "not a key of it, allowed are " + list);
    }
  }

 private:
  const XmlRpcValue& value_;
  std::string path_;
  std::set<std::string> known_;
};

void read_intrinsics(Struct* keys, const std::string& path, Pinhole* camera) {
  keys->read("width", 1, kMostPixels, &camera->width);
  keys->read("height", 1, kMostPixels, &camera->height);
  double hfov = 0.0;
  const bool by_angle = keys->read_real("hfov", 1e-3, kWidestView, &hfov);
  const bool by_length = keys->read_real("fx", 1.0, kMostFocal, &camera->fx);
  if (by_angle == by_length) {
    refuse(path, by_angle ? "hfov and fx say the same thing, one is needed" : "hfov (rad) or fx (pixels) is needed");
  }
  if (by_angle) camera->fx = 0.5 * camera->width / std::tan(0.5 * hfov);
  camera->fy = camera->fx;
  keys->read_real("fy", 1.0, kMostFocal, &camera->fy);
  camera->cx = 0.5 * (camera->width - 1);
  camera->cy = 0.5 * (camera->height - 1);
  keys->read_real("cx", -kMostFocal, kMostFocal, &camera->cx);
  keys->read_real("cy", -kMostFocal, kMostFocal, &camera->cy);
  keys->read_real("near", 1e-4, 1e3, &camera->near);
  keys->read_real("far", 1e-3, 1e4, &camera->far);
  if (camera->near >= camera->far) refuse(path + "/near", "must be less than far");
}

void read_noise(const XmlRpcValue& value, const std::string& path, DepthNoise* noise) {
  Struct keys(value, path);
  keys.read_real("sigma", 0.0, 10.0, &noise->sigma);
  keys.read_real("sigma_growth", 0.0, 10.0, &noise->sigma_growth);
  keys.read_real("sigma_distance", 0.0, 1e3, &noise->sigma_distance);
  keys.read_real("baseline", 0.0, 10.0, &noise->baseline);
  keys.read_real("disparity_step", 1e-6, 100.0, &noise->disparity_step);
  keys.read_real("grazing_angle", 0.0, 0.5 * M_PI, &noise->grazing_angle);
  keys.read_real("dropout", 0.0, 1.0, &noise->dropout);
  int seed = 0;
  keys.read("seed", 0, 1000000000, &seed);
  noise->seed = static_cast<std::uint64_t>(seed);
  keys.check_keys();
}

CameraParameters to_camera(const std::string& name, const XmlRpcValue& value) {
  CameraParameters camera;
  const std::string path = "cameras/" + printable(name);
  check_name("parameter ~cameras:", name);
  camera.name = name;
  Struct keys(value, path);
  keys.read("frame", &camera.frame);
  if (camera.frame.empty() || camera.frame[0] == '/') {
    refuse(path + "/frame", "the tf frame of the camera, optical and without leading slash, is needed");
  }
  read_intrinsics(&keys, path, &camera.pinhole);
  keys.read_real("rate", 0.0, 1000.0, &camera.rate);
  if (const XmlRpcValue* noise = keys.find("noise")) read_noise(*noise, path + "/noise", &camera.noise);
  keys.check_keys();
  return camera;
}

}  // namespace

std::vector<CameraParameters> to_cameras(const XmlRpcValue& value) {
  if (value.getType() != XmlRpcValue::TypeStruct) {
    refuse("cameras", "cameras by their names are needed: {name: {frame: ..., hfov: ...}}");
  }
  std::vector<CameraParameters> cameras;
  for (const auto& [name, camera] : value) cameras.push_back(to_camera(name, camera));
  return cameras;
}

}  // namespace deformable_sim
