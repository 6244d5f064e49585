#include "deformable_sim/rviz/bar_list.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <QPainter>

namespace deformable_sim {

namespace {

constexpr int kShortestBar = 60;  // pixels, before names are cut

}  // namespace

BarList::BarList(QWidget* parent) : QWidget(parent) {
  setSizePolicy(QSizePolicy::Expanding, QSizePolicy::Fixed);
}

void BarList::set_rows(std::vector<Row> rows) {
  const bool resized = rows.size() != rows_.size();
  rows_ = std::move(rows);
  if (resized) updateGeometry();
  update();
}

int BarList::row_height() const {
  return fontMetrics().height() + 3;
}

QSize BarList::sizeHint() const {
  return {240, static_cast<int>(rows_.size()) * row_height()};
}

QSize BarList::minimumSizeHint() const {
  return {160, sizeHint().height()};
}

void BarList::paintEvent(QPaintEvent*) {
  QPainter painter(this);
  int name_width = 0, text_width = 0;
  for (const Row& row : rows_) {
    name_width = std::max(name_width, fontMetrics().horizontalAdvance(row.name + " "));
    text_width = std::max(text_width, fontMetrics().horizontalAdvance(" " + row.text));
  }
  name_width = std::min(name_width, std::max(width() / 4, width() - text_width - kShortestBar));
  const int bar_left = name_width + 4;
  const int bar_width = std::max(0, width() - bar_left - text_width - 5);
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const Row& row = rows_[i];
    const int top = static_cast<int>(i) * row_height();
    painter.setPen(palette().color(QPalette::WindowText));
    painter.drawText(QRect(0, top, name_width, row_height()), Qt::AlignLeft | Qt::AlignVCenter,
                     fontMetrics().elidedText(row.name, Qt::ElideRight, name_width));
    painter.drawText(QRect(0, top, width(), row_height()), Qt::AlignRight | Qt::AlignVCenter, row.text);
    const double fraction = std::isfinite(row.fraction) ? std::clamp(row.fraction, 0.0, 1.0) : 0.0;
    const QRect bar(bar_left, top + 3, bar_width, row_height() - 6);
    painter.fillRect(bar, palette().color(QPalette::Base));
    painter.fillRect(QRect(bar.topLeft(), QSize(static_cast<int>(std::lround(fraction * bar_width)), bar.height())),
                     row.color);
    painter.setPen(palette().color(QPalette::Mid));
    painter.drawRect(bar.adjusted(0, 0, -1, -1));
  }
}

}  // namespace deformable_sim
