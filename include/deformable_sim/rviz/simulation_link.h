// What the panel asks of a simulation and what it hears from it. No call waits; answers come as signals.
#pragma once

#include <QObject>
#include <QString>
#include <QStringList>

#include "deformable_sim/GraspStateArray.h"
#include "deformable_sim/SimStatus.h"

namespace deformable_sim {

class SimulationLink : public QObject {
  Q_OBJECT

 public:
  explicit SimulationLink(QObject* parent = nullptr);

  /// Listens to the node of this absolute name, and to no other, until close().
  virtual void open(const QString& node) = 0;
  virtual void close() = 0;

  // Requests to the open node; each is followed by one answered().
  virtual void set_paused(bool paused) = 0;
  virtual void step(unsigned count) = 0;
  virtual void reset() = 0;
  virtual void load_scene(const QString& name_or_file) = 0;
  virtual void set_color_by(const QString& quantity) = 0;

  /// Followed by nodes_found() and scenes_found().
  virtual void look_around() = 0;

 Q_SIGNALS:
  void status_received(QString node, deformable_sim::SimStatusConstPtr status);
  void grasps_received(QString node, deformable_sim::GraspStateArrayConstPtr grasps);
  void color_by_received(QString node, QString quantity);
  void answered(QString node, bool accepted, QString message);
  void nodes_found(QStringList nodes);
  void scenes_found(QStringList names);
};

}  // namespace deformable_sim
