// The contents of the panel: controls above, readings below. Knows ROS only through a SimulationLink.
#pragma once

#include <QComboBox>
#include <QElapsedTimer>
#include <QLabel>
#include <QPushButton>
#include <QTimer>
#include <QWidget>

#include "deformable_sim/rviz/readings.h"
#include "deformable_sim/rviz/simulation_link.h"

namespace deformable_sim {

class SimulationView : public QWidget {
  Q_OBJECT

 public:
  /// `link` outlives this.
  explicit SimulationView(SimulationLink* link, QWidget* parent = nullptr);

  QString node() const { return node_; }
  /// Text that is no node name is left out of account.
  void set_node(const QString& name);

 Q_SIGNALS:
  void node_changed();

 protected:
  // The node is listened to while this is on the screen, and not otherwise.
  void showEvent(QShowEvent* event) override;
  void hideEvent(QHideEvent* event) override;

 private:
  QWidget* make_choices();
  QWidget* make_buttons();
  void connect_link();

  /// Says what is being asked and locks the controls until the answer; `ask` makes the request.
  template <class Ask>
  void request(const QString& what, Ask ask);
  void lock_controls(bool locked);
  void say(const QString& text, bool problem);
  void choose_scene_file();
  void reopen();
  void tick();

  void on_status(const QString& node, const SimStatusConstPtr& status);
  void on_color_by(const QString& node, const QString& quantity);
  void on_answer(const QString& node, bool accepted, const QString& message);
  void on_nodes(const QStringList& nodes);
  void on_scenes(const QStringList& names);

  SimulationLink* link_;
  QString node_;
  QString asked_;  // what the last request was, empty when it was answered
  bool paused_ = false;
  bool silent_ = true;  // no status has come for a while
  QElapsedTimer heard_;
  int ticks_ = 0;
  QTimer timer_;

  QComboBox* node_box_;
  QComboBox* scene_box_;
  QComboBox* color_box_;
  QPushButton* browse_;
  QPushButton* load_;
  QPushButton* play_;
  QPushButton* pause_;
  QPushButton* step_;
  QPushButton* step_10_;
  QPushButton* reset_;
  QLabel* connection_;
  QLabel* message_;
  Readings* readings_;
};

}  // namespace deformable_sim
