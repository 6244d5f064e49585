// The link to a simulation over ROS. Whatever may wait for the master or a node is done on a thread of its own.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <dynamic_reconfigure/Config.h>
#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>

#include "deformable_sim/rviz/simulation_link.h"

namespace deformable_sim {

class RosLink : public SimulationLink {
 public:
  RosLink();
  ~RosLink() override;

  void open(const QString& node) override;
  void close() override;
  void set_paused(bool paused) override;
  void step(unsigned count) override;
  void reset() override;
  void load_scene(const QString& name_or_file) override;
  void set_color_by(const QString& quantity) override;
  void look_around() override;

 private:
  struct Answer {
    bool accepted;
    std::string message;
  };

  /// Has the worker run `job` after those before it.
  void enqueue(std::function<void()> job);
  void work();

  /// Has the worker call a service of the open node; `judge` reads the answer.
  template <class Service>
  void request(const std::string& name, Service service, double patience, std::function<Answer(const Service&)> judge);

  /// False where the node did not answer within `patience` seconds of wall time.
  template <class Service>
  bool call(const std::string& name, Service* service, double patience);

  /// Ends the call that is under way, if any.
  void abandon_call();
  void abandon_late_call();

  void subscribe(const QString& node);
  void unsubscribe();
  void find_nodes();
  void find_scenes();
  void on_parameters(const QString& node, const dynamic_reconfigure::Config& values);

  ros::CallbackQueue queue_;
  ros::NodeHandle handle_;
  ros::AsyncSpinner spinner_;
  ros::WallTimer watchdog_;
  std::vector<ros::Subscriber> subscribers_;  // of the worker

  std::mutex mutex_;  // of all below
  std::condition_variable changed_;
  std::deque<std::function<void()>> jobs_;
  QString node_;
  ros::ServiceClient call_;
  ros::WallTime call_deadline_;
  bool looking_ = false;  // a look_around() waits for the worker
  bool ending_ = false;
  bool ended_ = false;

  std::thread worker_;
};

}  // namespace deformable_sim
