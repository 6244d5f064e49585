// A node that outlives its master.
#pragma once

#include <string>
#include <vector>

namespace deformable_sim {

/// roscpp registers once and never again: after a restart of roscore a node is deaf and mute though it runs. Asked
/// every few seconds, this notices a master that does not know the node, and registers all its topics and services
/// anew.
class MasterWatch {
 public:
  MasterWatch();
  /// `services`: full names of the services besides those of roscpp.
  void check(const std::vector<std::string>& services);

 private:
  bool lost_ = false;
  bool incomplete_ = false;  // a call failed when registering again
  std::string service_uri_;
};

}  // namespace deformable_sim
