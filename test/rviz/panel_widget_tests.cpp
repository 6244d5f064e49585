// The panel's widget without ROS: a link that writes down what it is asked, and messages made by hand.
#include <cmath>
#include <stdexcept>
#include <utility>
#include <vector>

#include <QApplication>
#include <QComboBox>
#include <QLabel>
#include <QLineEdit>
#include <QPushButton>
#include <QThread>

#include <gtest/gtest.h>
#include <boost/make_shared.hpp>

#include "deformable_sim/rviz/graph_names.h"
#include "deformable_sim/rviz/number_text.h"
#include "deformable_sim/rviz/plot.h"
#include "deformable_sim/rviz/simulation_view.h"

namespace deformable_sim {
namespace {

class WrittenLink : public SimulationLink {
 public:
  void open(const QString& node) override { asked << "open " + node; }
  void close() override { asked << "close"; }
  void set_paused(bool paused) override { asked << (paused ? "pause" : "play"); }
  void step(unsigned count) override { asked << "step " + QString::number(count); }
  void reset() override { asked << "reset"; }
  void load_scene(const QString& name_or_file) override { asked << "load " + name_or_file; }
  void set_color_by(const QString& quantity) override { asked << "color_by " + quantity; }
  void look_around() override {}

  QStringList asked;
};

SimStatusConstPtr status(double time, bool paused) {
  auto message = boost::make_shared<SimStatus>();
  message->time = time;
  message->paused = paused;
  message->real_time_factor = 1.0;
  message->integrator = "implicit_euler";
  message->part = {"solver", "contact"};
  message->part_cost = {0.3, 0.1};
  message->warnings = {"<b>late</b>"};
  return message;
}

class Panel : public testing::Test {
 protected:
  Panel() : view(&link) {
    view.set_node("deformable_sim");
    view.show();
    link.asked.clear();
  }

  template <class Widget>
  Widget* find(const char* name) {
    auto* widget = view.findChild<Widget*>(name);
    if (!widget) throw std::runtime_error(name);
    return widget;
  }

  void click(const char* name) { find<QPushButton>(name)->click(); }
  bool enabled(const char* name) { return find<QPushButton>(name)->isEnabled(); }
  QString text(const char* name) { return find<QLabel>(name)->text(); }

  /// Lets timers and queued signals act until `condition`, for at most ten seconds.
  template <class Condition>
  bool wait(Condition condition) {
    for (int i = 0; i < 1000 && !condition(); ++i) {
      QApplication::processEvents();
      QThread::msleep(10);
    }
    return condition();
  }

  void hear(double time, bool paused) { Q_EMIT link.status_received("/deformable_sim", status(time, paused)); }

  WrittenLink link;
  SimulationView view;
};

TEST_F(Panel, EachButtonAsksForOneThing) {
  const std::vector<std::pair<const char*, QString>> buttons = {
      {"play", "play"}, {"pause", "pause"}, {"step", "step 1"}, {"step_10", "step 10"}, {"reset", "reset"}};
  for (const auto& [name, request] : buttons) {
    link.asked.clear();
    click(name);
    EXPECT_EQ(link.asked, QStringList(request));
    Q_EMIT link.answered("/deformable_sim", true, "");
  }
}

TEST_F(Panel, PlayAndPauseFollowTheSimulation) {
  hear(1, true);
  EXPECT_TRUE(enabled("play"));
  EXPECT_FALSE(enabled("pause"));
  hear(1, false);
  EXPECT_FALSE(enabled("play"));
  EXPECT_TRUE(enabled("pause"));
}

TEST_F(Panel, OneRequestIsMadeAtATime) {
  click("reset");
  EXPECT_FALSE(enabled("step"));
  hear(1, false);
  EXPECT_FALSE(enabled("pause"));
  Q_EMIT link.answered("/deformable_sim", true, "");
  EXPECT_TRUE(enabled("step"));
}

TEST_F(Panel, ShowsWhyARequestWasRefused) {
  click("step");
  Q_EMIT link.answered("/deformable_sim", false, "time runs: pause first");
  EXPECT_EQ(text("message"), "step: refused; time runs: pause first");
}

TEST_F(Panel, LoadsTheSceneThatWasTyped) {
  Q_EMIT link.scenes_found({"flag", "towel_on_table"});
  EXPECT_EQ(find<QComboBox>("scene")->count(), 2);
  click("load");
  EXPECT_TRUE(link.asked.isEmpty());  // none was chosen
  find<QComboBox>("scene")->setEditText("/some/where.yaml");
  click("load");
  EXPECT_EQ(link.asked, QStringList("load /some/where.yaml"));
}

TEST_F(Panel, AColourIsAskedForOnlyWhenAPersonChoosesIt) {
  auto* box = find<QComboBox>("color_by");
  Q_EMIT link.color_by_received("/deformable_sim", "strain");
  EXPECT_EQ(box->currentText(), "strain");
  EXPECT_TRUE(link.asked.isEmpty());
  Q_EMIT box->activated(box->findText("stress"));
  EXPECT_EQ(link.asked, QStringList("color_by stress"));
}

TEST_F(Panel, ListensOnlyWhileItIsShown) {
  view.hide();
  EXPECT_EQ(link.asked, QStringList("close"));
  view.show();
  EXPECT_EQ(link.asked, QStringList({"close", "open /deformable_sim"}));
}

TEST_F(Panel, GoesToAnotherNodeAndNotToWhatIsNoName) {
  view.set_node("bad name;");
  EXPECT_EQ(view.node(), "/deformable_sim");
  EXPECT_TRUE(link.asked.isEmpty());
  view.set_node("/cell/left");
  EXPECT_EQ(link.asked, QStringList("open /cell/left"));
  // What the old node said last is no longer of interest.
  hear(1, true);
  EXPECT_EQ(text("connection"), "connecting to /cell/left ...");
}

TEST_F(Panel, SaysThatANodeIsSilent) {
  hear(1, false);
  EXPECT_TRUE(wait([this] { return text("connection") == "no answer from /deformable_sim"; }));
}

TEST_F(Panel, ShowsCostGraspsAndWarnings) {
  hear(2.5, false);
  auto grasps = boost::make_shared<GraspStateArray>();
  grasps->grasps.resize(2);
  grasps->grasps[0].wrench.force.z = 3;  // N, half of its limit
  grasps->grasps[0].load = 0.5;
  grasps->grasps[1].state = GraspState::SLIPPED;
  Q_EMIT link.grasps_received("/deformable_sim", grasps);
  auto* cost = find<BarList>("cost");
  auto* bars = find<BarList>("grasps");
  ASSERT_TRUE(wait([&] { return cost->rows().size() == 2 && bars->rows().size() == 2; }));
  EXPECT_DOUBLE_EQ(cost->rows()[0].fraction, 0.75);  // 0.3 / (0.3 + 0.1)
  EXPECT_EQ(cost->rows()[0].text, "300 ms, 75 %");
  EXPECT_DOUBLE_EQ(bars->rows()[0].fraction, 0.5);
  EXPECT_EQ(bars->rows()[0].text, "3.00 N, 50 % of limit");
  EXPECT_EQ(bars->rows()[1].text, "slipped");
  EXPECT_EQ(text("warnings"), "<b>late</b>");
  EXPECT_EQ(find<QLabel>("warnings")->textFormat(), Qt::PlainText);
  EXPECT_TRUE(text("summary").startsWith("t = 2.50 s"));
}

TEST(Plot, KeepsTheLastMinute) {
  Plot plot("", "", {{"", Qt::black}}, Plot::Axis::kFitted);
  for (int t = 0; t <= 200; ++t) plot.add(t, {static_cast<double>(t)});
  EXPECT_EQ(plot.size(), 61u);  // 140 ... 200 s
  EXPECT_EQ(plot.range(), std::make_pair(140.0, 200.0));
}

TEST(Plot, CanBeginAtZero) {
  Plot plot("", "", {{"", Qt::black}}, Plot::Axis::kFromZero);
  plot.add(0, {0.99});
  plot.add(1, {1.01});
  EXPECT_EQ(plot.range(), std::make_pair(0.0, 1.01));
}

TEST(Plot, BeginsAnewWhenTimeGoesBack) {
  Plot plot("", "", {{"", Qt::black}}, Plot::Axis::kFitted);
  plot.add(5, {1});
  plot.add(6, {2});
  plot.add(6, {3});  // paused, and changed by hand
  EXPECT_EQ(plot.size(), 2u);
  EXPECT_EQ(plot.range(), std::make_pair(1.0, 3.0));
  plot.add(0.01, {7});
  EXPECT_EQ(plot.size(), 1u);
}

TEST(Plot, HoldsABoundedNumberOfSamplesAndDrawsWhatIsNotFinite) {
  Plot plot("title", "J", {{"a", Qt::black}, {"b", Qt::red}}, Plot::Axis::kFromZero);
  for (int i = 0; i < 10000; ++i) plot.add(1e-3 * i, {i % 7 == 0 ? NAN : 1.0 * i, -1.0 * i});
  EXPECT_EQ(plot.size(), Plot::kCapacity);
  plot.resize(300, 80);
  EXPECT_FALSE(plot.grab().isNull());
}

TEST(WithUnit, GivesThreeDigitsAndAPrefix) {
  EXPECT_EQ(with_unit(0.00123, "J"), "1.23 mJ");
  EXPECT_EQ(with_unit(-45.6, "N"), "-45.6 N");
  EXPECT_EQ(with_unit(999.9, "J"), "1.00 kJ");
  EXPECT_EQ(with_unit(0, "J"), "0 J");
  EXPECT_EQ(with_unit(NAN, "J"), "-");
  EXPECT_EQ(with_unit(0.98765, ""), "0.99");
  EXPECT_EQ(with_unit(2.6e-5, "%"), "0.00 %");
  EXPECT_EQ(with_unit(12.345, "%"), "12.3 %");
}

TEST(NodeName, HasLettersDigitsUnderscoresAndSlashes) {
  for (const char* good : {"sim", "/sim", "/cell_1/sim"}) EXPECT_TRUE(is_node_name(good)) << good;
  for (const char* bad : {"", "/", "a b", "1a", "a//b", "a/", "~a", "a;b", "ä"}) EXPECT_FALSE(is_node_name(bad)) << bad;
}

}  // namespace
}  // namespace deformable_sim

int main(int argc, char** argv) {
  qputenv("QT_QPA_PLATFORM", "offscreen");
  testing::InitGoogleTest(&argc, argv);
  const QApplication application(argc, argv);
  return RUN_ALL_TESTS();
}
