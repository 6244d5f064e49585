// Curves over the last minute of simulated time, in a small widget.
#pragma once

#include <deque>
#include <vector>

#include <QColor>
#include <QString>
#include <QWidget>

namespace deformable_sim {

class Plot : public QWidget {
  Q_OBJECT

 public:
  struct Curve {
    QString name;  // may be empty where there is one
    QColor color;
  };

  static constexpr double kWindow = 60.0;         // s
  static constexpr std::size_t kCapacity = 4096;  // samples

  enum class Axis { kFitted, kFromZero };  // of the values

  Plot(const QString& title, const QString& unit, std::vector<Curve> curves, Axis axis, QWidget* parent = nullptr);

  /// One value a curve, at a time in s; a second sample of the same time replaces the first, and a time before the last
  /// one begins anew.
  void add(double time, const std::vector<double>& values);
  void clear();

  std::size_t size() const { return samples_.size(); }
  /// Simulated time that is shown, s.
  double span() const;
  /// Smallest and largest value of the axis.
  std::pair<double, double> range() const;

  QSize sizeHint() const override;
  QSize minimumSizeHint() const override;

 protected:
  void paintEvent(QPaintEvent* event) override;

 private:
  struct Sample {
    double time;
    std::vector<double> values;
  };

  void paint_legend(QPainter* painter, const QRectF& line) const;
  void paint_curves(QPainter* painter, const QRectF& area, double low, double high) const;

  QString title_;
  QString unit_;
  std::vector<Curve> curves_;
  Axis axis_;
  std::deque<Sample> samples_;
};

}  // namespace deformable_sim
