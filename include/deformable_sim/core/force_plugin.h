// A term of the equations of motion from outside the package.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "deformable_sim/core/energy/energy.h"
#include "deformable_sim/core/model.h"

namespace deformable_sim {

/// What a scene says of a force: `- {plugin: PACKAGE/CLASS, body: NAME, parameters: {key: number or list}}`.
struct ForceRequest {
  std::string plugin;
  std::string body;                                       // empty: all bodies
  std::map<std::string, std::vector<double>> parameters;  // SI units, as the plugin says

  /// One number; `standard` where it is absent. Throws InputError where it is a list.
  double number(const std::string& key, double standard) const;
  /// Three numbers. Throws InputError where they are absent or not three.
  Vec3 vector(const std::string& key) const;
  /// Throws InputError naming a key that is none of `known`, and those.
  void check_keys(const std::vector<std::string>& known) const;
};

/// Makes terms of other people's classes. Where the node runs it is loaded by name (pluginlib, doc/extending.md); a
/// program of its own passes one to build_world(). It and its library live as long as the terms.
class ForcePlugin {
 public:
  virtual ~ForcePlugin() = default;
  /// A term for the nodes of request.body (model.find_body()), or of all bodies, whose places and masses are in the
  /// model. Throws InputError for what the scene asks wrongly; the scene is then refused at its line.
  virtual std::unique_ptr<Energy> make(const ForceRequest& request, const Model& model) = 0;
};

}  // namespace deformable_sim
