// The panel as rviz makes it, by pluginlib, clicked beside a running node. Needs a master: test/ros/panel.test.
#include <signal.h>

#include <algorithm>
#include <cmath>
#include <string>

#include <QApplication>
#include <QComboBox>
#include <QLabel>
#include <QPushButton>
#include <QThread>

#include <XmlRpc.h>
#include <gtest/gtest.h>
#include <ros/network.h>
#include <ros/ros.h>
#include <rviz/config.h>
#include <rviz/panel.h>
#include <pluginlib/class_loader.hpp>

#include "deformable_sim/SimStatus.h"

namespace deformable_sim {
namespace {

/// Process id of a node of this machine, as it says itself; 0 where it cannot be asked.
int process_of(const std::string& name) {
  XmlRpc::XmlRpcValue arguments, answer, address;
  arguments[0] = ros::this_node::getName();
  arguments[1] = name;
  std::string host;
  uint32_t port = 0;
  if (!ros::master::execute("lookupNode", arguments, answer, address, false)) return 0;
  if (!ros::network::splitURI(address, host, port)) return 0;
  XmlRpc::XmlRpcClient client(host.c_str(), static_cast<int>(port), "/");
  XmlRpc::XmlRpcValue pid, caller;
  caller[0] = ros::this_node::getName();
  return client.execute("getPid", caller, pid) ? static_cast<int>(pid[2]) : 0;
}

class PanelPlugin : public testing::Test {
 protected:
  PanelPlugin() : loader("rviz", "rviz::Panel"), panel(loader.createUniqueInstance("deformable_sim/Simulation")) {
    status_topic = node.subscribe("/deformable_sim/status", 10, &PanelPlugin::on_status, this);
    panel->resize(340, 800);
    panel->show();
  }

  void on_status(const SimStatusConstPtr& message) { last = message; }

  /// Lets Qt and ROS act until `condition`, for at most 20 s.
  template <class Condition>
  bool wait(Condition condition) {
    const ros::WallTime end = ros::WallTime::now() + ros::WallDuration(20);
    while (!condition() && ros::WallTime::now() < end) {
      const ros::WallTime start = ros::WallTime::now();
      QApplication::processEvents();
      longest = std::max(longest, (ros::WallTime::now() - start).toSec());
      ros::spinOnce();
      QThread::msleep(5);
    }
    return condition();
  }

  QPushButton* button(const char* name) { return panel->findChild<QPushButton*>(name); }
  QString text(const char* name) { return panel->findChild<QLabel*>(name)->text(); }

  bool click(const char* name) {
    if (!wait([&] { return button(name)->isEnabled(); })) return false;
    button(name)->click();
    return wait([&] { return !text("message").endsWith("..."); });
  }

  ros::NodeHandle node;
  ros::Subscriber status_topic;
  SimStatusConstPtr last;
  double longest = 0;  // s that Qt was busy at once
  pluginlib::ClassLoader<rviz::Panel> loader;
  pluginlib::UniquePtr<rviz::Panel> panel;
};

TEST_F(PanelPlugin, StepsResetsAndPlaysTheNode) {
  ASSERT_TRUE(wait([&] { return last && last->paused && text("connection") == "paused"; }));
  ASSERT_TRUE(click("step_10"));
  EXPECT_EQ(text("message"), "10 steps: done");
  EXPECT_TRUE(wait([&] { return std::abs(last->time - 10 * last->step) < 1e-9; }));
  ASSERT_TRUE(click("reset"));
  EXPECT_TRUE(wait([&] { return last->time == 0; }));
  ASSERT_TRUE(click("play"));
  EXPECT_TRUE(wait([&] { return !last->paused && last->time > 0; }));
  ASSERT_TRUE(click("step"));
  EXPECT_TRUE(text("message").startsWith("step: refused; ")) << text("message").toStdString();
  ASSERT_TRUE(click("pause"));
  EXPECT_TRUE(wait([&] { return last->paused != 0; }));
}

TEST_F(PanelPlugin, ListsNodesAndScenesAndLoadsOne) {
  auto* scenes = panel->findChild<QComboBox*>("scene");
  auto* nodes = panel->findChild<QComboBox*>("node");
  ASSERT_TRUE(wait([&] { return scenes->findText("minimal") >= 0 && nodes->findText("/deformable_sim") >= 0; }));
  scenes->setEditText("no_such_scene");
  ASSERT_TRUE(click("load"));
  EXPECT_TRUE(text("message").startsWith("load no_such_scene: refused; ")) << text("message").toStdString();
  scenes->setEditText("minimal");
  ASSERT_TRUE(click("load"));
  EXPECT_EQ(text("message"), "load minimal: done");
}

TEST_F(PanelPlugin, ChangesTheColours) {
  auto* colors = panel->findChild<QComboBox*>("color_by");
  ASSERT_TRUE(wait([&] { return colors->currentIndex() >= 0; }));
  Q_EMIT colors->activated(colors->findText("velocity"));
  ASSERT_TRUE(wait([&] { return text("message") == "colour by velocity: done"; })) << text("message").toStdString();
  EXPECT_TRUE(wait([&] { return colors->currentText() == "velocity"; }));
}

TEST_F(PanelPlugin, SavesTheNodeItWatches) {
  rviz::Config config;
  config.mapSetValue("Simulation Node", "cell/left");
  panel->load(config);
  rviz::Config saved;
  panel->save(saved);
  QString name;
  ASSERT_TRUE(saved.mapGetString("Simulation Node", &name));
  EXPECT_EQ(name, "/cell/left");
}

// A stopped process accepts connections and answers nothing: the worst a node can do.
TEST_F(PanelPlugin, IsNotHeldUpByANodeThatHangs) {
  ASSERT_TRUE(wait([&] { return last && button("reset")->isEnabled(); }));
  const int pid = process_of("/deformable_sim");
  ASSERT_GT(pid, 0);
  ASSERT_EQ(kill(pid, SIGSTOP), 0);
  longest = 0;
  button("reset")->click();
  const bool told = wait([&] { return text("message") == "reset: refused; no answer from /deformable_sim"; });
  const std::string text_told = text("message").toStdString();
  const ros::WallTime start = ros::WallTime::now();
  button("reset")->click();
  panel.reset();
  const double closing = (ros::WallTime::now() - start).toSec();
  kill(pid, SIGCONT);
  EXPECT_TRUE(told) << text_told;
  EXPECT_LT(longest, 2.0);  // s; a held-up panel would be busy for the 8 s it waits
  EXPECT_LT(closing, 2.0);
}

}  // namespace
}  // namespace deformable_sim

int main(int argc, char** argv) {
  qputenv("QT_QPA_PLATFORM", "offscreen");
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "panel_plugin");
  const QApplication application(argc, argv);
  const ros::NodeHandle node;  // keeps ROS up
  return RUN_ALL_TESTS();
}
