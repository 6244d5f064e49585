#include "deformable_sim/rviz/readings.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include <QFont>
#include <QVBoxLayout>

#include "deformable_sim/rviz/number_text.h"

namespace deformable_sim {
namespace {

const QColor kBlue(31, 97, 168);
const QColor kRed(188, 44, 38);
const QColor kGreen(40, 128, 64);
const QColor kAmber(190, 124, 0);
const QColor kViolet(116, 70, 160);

constexpr std::size_t kMostRows = 32;  // a message may have thousands of grasps

double norm(const geometry_msgs::Vector3& v) {
  return std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
}

QLabel* heading(const QString& text) {
  auto* label = new QLabel(text);
  QFont font = label->font();
  font.setBold(true);
  label->setFont(font);
  label->setWordWrap(true);  // text never makes the panel wider
  return label;
}

/// Text that others wrote is shown as it is, broken where it is too long.
QLabel* foreign_text() {
  auto* label = new QLabel;
  label->setTextFormat(Qt::PlainText);
  label->setWordWrap(true);
  label->setTextInteractionFlags(Qt::TextSelectableByMouse);
  return label;
}

QString state_text(const GraspState& grasp) {
  switch (grasp.state) {
    case GraspState::SLIPPED:
      return "slipped";
    case GraspState::WAITING_FOR_FRAME:
      return "waits for its frame";
    default:
      return "";
  }
}

}  // namespace

Readings::Readings(QWidget* parent) : QWidget(parent) {
  summary_ = foreign_text();
  summary_->setObjectName("summary");
  real_time_factor_ = new Plot("Real-time factor", "", {{"", kBlue}}, Plot::Axis::kFromZero);
  strain_ = new Plot("Largest strain", "%", {{"", kRed}}, Plot::Axis::kFromZero);
  energy_ = new Plot("Energy", "J", {{"kinetic", kGreen}, {"elastic", kViolet}}, Plot::Axis::kFromZero);
  potential_ = new Plot("Potential energy", "J", {{"", kAmber}}, Plot::Axis::kFitted);
  span_ = new QLabel;
  span_->setAlignment(Qt::AlignRight);
  span_->setWordWrap(true);
  span_->setEnabled(false);
  cost_title_ = heading("");
  cost_ = new BarList;
  cost_->setObjectName("cost");
  grasps_title_ = heading("");
  grasps_ = new BarList;
  grasps_->setObjectName("grasps");
  warnings_ = foreign_text();
  warnings_->setObjectName("warnings");

  auto* layout = new QVBoxLayout(this);
  layout->setContentsMargins(0, 0, 0, 0);
  layout->setSpacing(4);
  for (QWidget* widget :
       std::initializer_list<QWidget*>{summary_, real_time_factor_, strain_, energy_, potential_, span_, cost_title_,
                                       cost_, grasps_title_, grasps_, heading("Warnings"), warnings_}) {
    layout->addWidget(widget);
  }
  layout->addStretch(1);
  clear();
}

void Readings::add(const SimStatusConstPtr& status) {
  if (status_ && status->time < status_->time) largest_force_ = 0;  // a reset, or another scene
  status_ = status;
  changed_ = true;
  // While nothing moves there is no factor to show.
  if (!status->paused && status->real_time_factor > 0) real_time_factor_->add(status->time, {status->real_time_factor});
  strain_->add(status->time, {100 * status->max_strain});
  energy_->add(status->time, {status->kinetic_energy, status->elastic_energy});
  potential_->add(status->time, {status->potential_energy});
}

void Readings::add(const GraspStateArrayConstPtr& grasps) {
  last_grasps_ = grasps;
  changed_ = true;
  for (const GraspState& grasp : grasps->grasps) {
    if (grasp.load == 0) largest_force_ = std::max(largest_force_, norm(grasp.wrench.force));
  }
}

void Readings::clear() {
  status_.reset();
  last_grasps_.reset();
  largest_force_ = 0;
  changed_ = false;
  for (Plot* plot : {real_time_factor_, strain_, energy_, potential_}) plot->clear();
  summary_->clear();
  span_->clear();
  cost_title_->setText("Step cost");
  cost_->set_rows({});
  grasps_title_->setText("Grasps");
  grasps_->set_rows({});
  warnings_->setText("none");
}

void Readings::refresh() {
  if (!changed_) return;
  changed_ = false;
  if (status_) refresh_status(*status_);
  if (last_grasps_) refresh_grasps(*last_grasps_);
  for (Plot* plot : {real_time_factor_, strain_, energy_, potential_}) plot->update();
}

void Readings::refresh_status(const SimStatus& status) {
  summary_->setText(QString("t = %1 s, step %2\n%3, %4 iterations")
                        .arg(status.time, 0, 'f', 2)
                        .arg(with_unit(status.step, "s"), QString::fromStdString(status.integrator))
                        .arg(status.iterations));
  span_->setText(QString("the last %1 s of simulated time").arg(strain_->span(), 0, 'f', 0));

  const std::size_t parts = std::min({status.part.size(), status.part_cost.size(), kMostRows});
  const double total = std::accumulate(status.part_cost.begin(), status.part_cost.end(), 0.0);
  std::vector<BarList::Row> rows;
  for (std::size_t i = 0; i < parts; ++i) {
    const double share = total > 0 ? status.part_cost[i] / total : 0.0;
    rows.push_back({QString::fromStdString(status.part[i]), share,
                    QString("%1, %2 %").arg(with_unit(status.part_cost[i], "s")).arg(100 * share, 0, 'f', 0), kBlue});
  }
  cost_title_->setText("Step cost: " + with_unit(total, "s") + " CPU per simulated s");
  cost_->set_rows(std::move(rows));

  QStringList warnings;
  for (const std::string& warning : status.warnings) warnings << QString::fromStdString(warning);
  warnings_->setText(warnings.isEmpty() ? QString("none") : warnings.join('\n'));
}

void Readings::refresh_grasps(const GraspStateArray& message) {
  std::vector<BarList::Row> rows;
  for (const GraspState& grasp : message.grasps) {
    if (rows.size() == kMostRows) break;
    const double force = norm(grasp.wrench.force);
    // A grasp without a limit is measured against the largest force seen.
    const double fraction = grasp.load > 0 ? grasp.load : largest_force_ > 0 ? force / largest_force_ : 0.0;
    QString text = with_unit(force, "N");
    if (grasp.load > 0) text += QString(", %1 % of limit").arg(100 * grasp.load, 0, 'f', 0);
    const QString state = state_text(grasp);
    if (!state.isEmpty()) text = state;
    const QColor color = !state.isEmpty() || grasp.load > 0.9 ? kRed : grasp.load > 0.6 ? kAmber : kGreen;
    rows.push_back({QString::fromStdString(grasp.name), fraction, text, color});
  }
  grasps_title_->setText(message.grasps.empty() ? QString("Grasps: none")
                                                : QString("Grasps: %1, force").arg(message.grasps.size()));
  grasps_->set_rows(std::move(rows));
}

}  // namespace deformable_sim
