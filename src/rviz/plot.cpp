#include "deformable_sim/rviz/plot.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <QPaintEvent>
#include <QPainter>
#include <QPainterPath>

#include "deformable_sim/rviz/number_text.h"

namespace deformable_sim {
namespace {

constexpr double kShortestSpan = 5.0;  // s: the first samples are not stretched over the whole width

/// Room for the two limits of the axis.
int area_height(const QFontMetrics& font) {
  return 2 * font.height() + 4;
}

}  // namespace

Plot::Plot(const QString& title, const QString& unit, std::vector<Curve> curves, Axis axis, QWidget* parent)
    : QWidget(parent), title_(title), unit_(unit), curves_(std::move(curves)), axis_(axis) {
  setSizePolicy(QSizePolicy::Expanding, QSizePolicy::Fixed);
}

void Plot::add(double time, const std::vector<double>& values) {
  if (!std::isfinite(time) || values.size() != curves_.size()) return;
  if (!samples_.empty() && time < samples_.back().time) samples_.clear();
  if (!samples_.empty() && time == samples_.back().time) samples_.pop_back();
  samples_.push_back({time, values});
  while (samples_.size() > kCapacity || samples_.front().time < time - kWindow) samples_.pop_front();
}

void Plot::clear() {
  samples_.clear();
  update();
}

double Plot::span() const {
  return samples_.empty() ? 0.0 : samples_.back().time - samples_.front().time;
}

std::pair<double, double> Plot::range() const {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Sample& sample : samples_) {
    for (double value : sample.values) {
      if (!std::isfinite(value)) continue;
      low = std::min(low, value);
      high = std::max(high, value);
    }
  }
  if (low > high) return {0.0, 0.0};
  if (axis_ == Axis::kFromZero) return {std::min(low, 0.0), std::max(high, 0.0)};
  return {low, high};
}

QSize Plot::sizeHint() const {
  return {240, fontMetrics().height() + area_height(fontMetrics()) + 6};
}

QSize Plot::minimumSizeHint() const {
  return {160, sizeHint().height()};
}

void Plot::paintEvent(QPaintEvent*) {
  QPainter painter(this);
  const int line = fontMetrics().height();
  paint_legend(&painter, QRectF(0, 0, width(), line));

  const int margin = fontMetrics().horizontalAdvance("-0.00 mW ");  // as wide as a label can be
  const QRectF area(margin, line + 2, width() - margin - 1, area_height(fontMetrics()));
  painter.setPen(palette().color(QPalette::Mid));
  painter.setBrush(palette().base());
  painter.drawRect(area);
  if (samples_.empty()) return;

  const auto [low, high] = range();
  painter.setPen(palette().color(QPalette::WindowText));
  const QRectF labels(0, area.top(), margin - 5, area.height());
  painter.drawText(labels, Qt::AlignRight | Qt::AlignTop, with_unit(high, unit_));
  if (low != high) painter.drawText(labels, Qt::AlignRight | Qt::AlignBottom, with_unit(low, unit_));
  painter.setClipRect(area);
  painter.setRenderHint(QPainter::Antialiasing);
  paint_curves(&painter, area.adjusted(1, 3, -1, -3), low, high);
}

void Plot::paint_legend(QPainter* painter, const QRectF& line) const {
  painter->setPen(palette().color(QPalette::WindowText));
  painter->drawText(line, Qt::AlignLeft | Qt::AlignVCenter, title_);
  // From the right: the last curve's name and value first.
  double right = line.right();
  for (std::size_t i = curves_.size(); i-- > 0;) {
    QString text = curves_[i].name;
    if (!samples_.empty()) text += (text.isEmpty() ? "" : " ") + with_unit(samples_.back().values[i], unit_);
    painter->setPen(curves_[i].color);
    painter->drawText(QRectF(line.left(), line.top(), right - line.left(), line.height()),
                      Qt::AlignRight | Qt::AlignVCenter, text);
    right -= fontMetrics().horizontalAdvance(text + "   ");
  }
}

void Plot::paint_curves(QPainter* painter, const QRectF& area, double low, double high) const {
  const double end = samples_.back().time;
  const double seconds = std::max(span(), kShortestSpan);
  // A constant lies in the middle.
  const double height = high > low ? high - low : 1.0;
  const double base = high > low ? low : low - 0.5;
  for (std::size_t i = 0; i < curves_.size(); ++i) {
    QPainterPath path;
    bool drawing = false;
    for (const Sample& sample : samples_) {
      const double value = sample.values[i];
      if (!std::isfinite(value)) {
        drawing = false;
        continue;
      }
      const QPointF point(area.right() - area.width() * (end - sample.time) / seconds,
                          area.bottom() - area.height() * (value - base) / height);
      drawing ? path.lineTo(point) : path.moveTo(point);
      drawing = true;
    }
    painter->setPen(QPen(curves_[i].color, 1.4));
    painter->setBrush(Qt::NoBrush);
    painter->drawPath(path);
  }
}

}  // namespace deformable_sim
