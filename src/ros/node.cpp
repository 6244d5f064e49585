#include "deformable_sim/ros/node.h"

#include <chrono>
#include <thread>

#include <ros/callback_queue.h>
#include <ros/console.h>
#include <ros/init.h>
#include <ros/master.h>
#include <ros/spinner.h>
#include <ros/this_node.h>
#include <rosgraph_msgs/Clock.h>

#include "deformable_sim/ros/commands.h"
#include "deformable_sim/ros/convert.h"
#include "deformable_sim/ros/live_parameters.h"
#include "deformable_sim/ros/network_files.h"
#include "deformable_sim/ros/topic_keeper.h"
#include "deformable_sim/ros/trajectory_action.h"

namespace deformable_sim {

namespace {

constexpr int kCallbackThreads = 6;  // some may wait: for tf, for steps, for a scene being built
constexpr int kRefused = 2;

/// roscpp ignores SIGINT while it waits for a master; waiting out here does not.
void wait_for_master() {
  for (int tries = 0; !ros::master::check(); ++tries) {
    if (tries % 50 == 0) ROS_WARN_NAMED("master", "waiting for the ROS master at %s", ros::master::getURI().c_str());
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
  }
}

/// Two clocks would make time jump for everybody. Throws InputError.
void check_no_other_clock() {
  XmlRpc::XmlRpcValue request, response, state;
  request[0] = ros::this_node::getName();
  if (!ros::master::execute("getSystemState", request, response, state, false)) return;
  for (int i = 0; i < state[0].size(); ++i) {
    if (std::string(state[0][i][0]) != "/clock") continue;
    for (int j = 0; j < state[0][i][1].size(); ++j) {
      const std::string node = state[0][i][1][j];
      if (node == ros::this_node::getName()) continue;
      throw InputError("parameter ~publish_clock: /clock is published by " + node + " already; one clock is allowed",
                       Code::kUnavailable);
    }
  }
}

}  // namespace

class SimulationServer::Parts {
 public:
  explicit Parts(const ros::NodeHandle& private_nh)
      : spinner_(kCallbackThreads, &queue_),
        nh_(on_queue(private_nh, &queue_)),
        parameters_(read_parameters(nh_)),
        files_(network_files(parameters_)),
        frames_(parameters_.frame_id, parameters_.tf_timeout),
        recorder_(nh_, parameters_.frame_id),
        simulation_(parameters_, &frames_, &warnings_, &recorder_),
        topics_(nh_, &simulation_, &frames_, &warnings_, &files_),
        loader_(nh_, parameters_, &frames_, &warnings_,
                [this](const std::string& grasp, const geometry_msgs::PoseStamped& target) {
                  topics_.target(grasp, target);
                }),
        changes_(&simulation_, &loader_, &files_),
        live_(nh_, &changes_, &warnings_),
        rollouts_(&simulation_, &loader_, &frames_, parameters_.frame_id),
        services_(nh_, parameters_, &simulation_, &frames_, &changes_, &rollouts_, &files_),
        trajectories_(nh_, &simulation_, &frames_, parameters_.frame_id) {
    LoadedScene scene = loader_.build(loader_.read(parameters_.scene, "", AllowedPaths()));
    if (ros::ok()) start(std::move(scene));
  }

  ~Parts() {
    simulation_.stop();
    trajectories_.stop();
    if (keeper_) keeper_->stop();
    spinner_.stop();
  }

 private:
  static ros::NodeHandle on_queue(ros::NodeHandle nh, ros::CallbackQueue* queue) {
    nh.setCallbackQueue(queue);
    return nh;
  }

  void start(LoadedScene scene) {
    const SceneSpec spec = scene.spec;
    if (parameters_.publish_clock) {
      check_no_other_clock();
      clock_ = nh_.advertise<rosgraph_msgs::Clock>("/clock", 10);
    }
    services_.start();
    topics_.start();
    live_.start(spec);
    trajectories_.start();
    std::vector<std::string> services = services_.names();
    services.push_back(live_.service());
    keeper_ = std::make_unique<TopicKeeper>(std::move(services));
    const auto names_changed = [this](const TopicNames& names, std::shared_ptr<PublisherSet> publishers) {
      keeper_->post([this, names, publishers] {
        for (const PublisherSet::Entry& entry : publishers->entries) entry.publisher->update(names);
        topics_.update(names.grasps);
      });
    };
    Simulation::TimeChanged time_changed;
    if (parameters_.publish_clock) {
      time_changed = [this](double time) {
        rosgraph_msgs::Clock message;
        message.clock.fromSec(time);
        clock_.publish(message);
      };
    }
    simulation_.start(std::move(scene), names_changed, time_changed);
    spinner_.start();
    ROS_INFO_NAMED("simulation", "running");
  }

  ros::CallbackQueue queue_;
  ros::AsyncSpinner spinner_;
  ros::NodeHandle nh_;
  Parameters parameters_;
  AllowedPaths files_;
  Warnings warnings_;
  Frames frames_;
  SessionRecorder recorder_;
  Simulation simulation_;
  CommandTopics topics_;
  SceneLoader loader_;
  SceneChanges changes_;
  LiveParameters live_;
  Rollouts rollouts_;
  Services services_;
  TrajectoryAction trajectories_;
  ros::Publisher clock_;
  std::unique_ptr<TopicKeeper> keeper_;
};

SimulationServer::SimulationServer(const ros::NodeHandle& private_nh) : parts_(std::make_unique<Parts>(private_nh)) {}
SimulationServer::~SimulationServer() = default;

namespace {

/// Whether an interrupt ends the node. roscpp acts on one within a tenth of a second; calls that it cut off fail
/// before.
bool is_interrupted() {
  for (int i = 0; i < 30 && !ros::isShuttingDown(); ++i) ros::WallDuration(0.01).sleep();
  return ros::isShuttingDown();
}

}  // namespace

int run_node(int argc, char** argv) {
  ros::init(argc, argv, "deformable_sim");
  wait_for_master();
  const ros::NodeHandle keeps_logging_alive;
  try {
    const SimulationServer server(ros::NodeHandle("~"));
    ros::AsyncSpinner spinner(1);  // of the global queue
    spinner.start();
    ros::waitForShutdown();
    return 0;
  } catch (const InputError& error) {
    // An interrupt while loading: parameters can no longer be read, and that is why they are missing.
    if (is_interrupted()) return 0;
    ROS_FATAL_STREAM_NAMED("simulation", error.what());
    return kRefused;
  } catch (const std::exception& error) {
    ROS_FATAL_STREAM_NAMED("simulation", error.what());
    return 1;
  }
}

}  // namespace deformable_sim
