#include "deformable_sim/rviz/simulation_view.h"

#include <QAbstractItemView>
#include <QCompleter>
#include <QFileDialog>
#include <QFormLayout>
#include <QHBoxLayout>
#include <QLineEdit>
#include <QRegularExpressionValidator>
#include <QScrollArea>
#include <QShowEvent>
#include <QStyle>
#include <QVBoxLayout>

#include "deformable_sim/rviz/graph_names.h"

namespace deformable_sim {
namespace {

constexpr int kRefreshPeriod = 100;  // ms: text and plots are drawn ten times a second, however often messages come
constexpr int kSilence = 3000;       // ms; a node speaks at least once a second
constexpr int kLookPeriod = 30;      // refreshes between looks for nodes

/// A combo box whose text may be typed and may be wider than the panel.
QComboBox* text_box(const QString& name) {
  auto* box = new QComboBox;
  box->setObjectName(name);
  box->setEditable(true);
  box->setInsertPolicy(QComboBox::NoInsert);
  box->setSizeAdjustPolicy(QComboBox::AdjustToMinimumContentsLengthWithIcon);
  box->setMinimumContentsLength(10);
  box->setSizePolicy(QSizePolicy::Expanding, QSizePolicy::Fixed);
  box->completer()->setCaseSensitivity(Qt::CaseSensitive);
  return box;
}

QPushButton* button(const QString& name, const QString& text, const QString& tip) {
  auto* made = new QPushButton(text);
  made->setObjectName(name);
  made->setToolTip(tip);
  made->setAutoDefault(false);
  made->setMinimumWidth(made->fontMetrics().horizontalAdvance(text) + 14);
  made->setSizePolicy(QSizePolicy::Ignored, QSizePolicy::Fixed);  // as wide as there is room, not as the style likes
  return made;
}

QLabel* message_label(const QString& name) {
  auto* label = new QLabel;
  label->setObjectName(name);
  label->setTextFormat(Qt::PlainText);  // others write it
  label->setWordWrap(true);
  label->setTextInteractionFlags(Qt::TextSelectableByMouse);
  return label;
}

/// New items under the text that is there, but not while a person looks at the old ones.
void replace_items(QComboBox* box, const QStringList& items) {
  if (box->view()->isVisible()) return;
  QStringList present;
  for (int i = 0; i < box->count(); ++i) present << box->itemText(i);
  if (present == items) return;
  const QString text = box->currentText();
  const QSignalBlocker quiet(box);
  box->clear();
  box->addItems(items);
  box->setCurrentIndex(box->findText(text));
  box->setEditText(text);
}

}  // namespace

SimulationView::SimulationView(SimulationLink* link, QWidget* parent) : QWidget(parent), link_(link) {
  connection_ = message_label("connection");
  message_ = message_label("message");
  readings_ = new Readings;

  auto* contents = new QWidget;
  auto* column = new QVBoxLayout(contents);
  column->setContentsMargins(6, 6, 6, 6);
  column->setSpacing(6);
  for (QWidget* widget :
       std::initializer_list<QWidget*>{make_choices(), make_buttons(), connection_, message_, readings_}) {
    column->addWidget(widget);
  }
  column->addStretch(1);
  auto* scroll = new QScrollArea;
  scroll->setWidgetResizable(true);
  scroll->setFrameShape(QFrame::NoFrame);
  scroll->setHorizontalScrollBarPolicy(Qt::ScrollBarAlwaysOff);
  scroll->setWidget(contents);
  scroll->setMinimumWidth(contents->minimumSizeHint().width() + style()->pixelMetric(QStyle::PM_ScrollBarExtent));
  auto* layout = new QVBoxLayout(this);
  layout->setContentsMargins(0, 0, 0, 0);
  layout->addWidget(scroll);

  message_->hide();
  connect_link();
  connect(&timer_, &QTimer::timeout, this, &SimulationView::tick);
  lock_controls(false);
}

QWidget* SimulationView::make_choices() {
  node_box_ = text_box("node");
  node_box_->setToolTip("Node of the simulation; those that run are listed");
  node_box_->setValidator(new QRegularExpressionValidator(QRegularExpression(node_name_pattern()), node_box_));
  connect(node_box_, QOverload<int>::of(&QComboBox::activated), this, [this] { set_node(node_box_->currentText()); });
  connect(node_box_->lineEdit(), &QLineEdit::editingFinished, this, [this] { set_node(node_box_->currentText()); });

  scene_box_ = text_box("scene");
  scene_box_->setToolTip("A shipped scene by name, or a file that the node may read");
  scene_box_->lineEdit()->setMaxLength(4096);
  scene_box_->lineEdit()->setPlaceholderText("name or file");
  browse_ = button("browse", "...", "Choose a scene file");
  load_ = button("load", "Load", "Load the scene into the running node");
  connect(browse_, &QPushButton::clicked, this, &SimulationView::choose_scene_file);
  connect(load_, &QPushButton::clicked, this, [this] {
    const QString scene = scene_box_->currentText().trimmed();
    if (scene.isEmpty()) return say("choose a scene first", true);
    request("load " + scene, [this, scene] { link_->load_scene(scene); });
  });
  auto* scene_row = new QHBoxLayout;
  scene_row->setSpacing(4);
  scene_row->addWidget(scene_box_, 6);
  scene_row->addWidget(browse_, 1);
  scene_row->addWidget(load_, 2);

  color_box_ = new QComboBox;
  color_box_->setObjectName("color_by");
  color_box_->addItems({"body", "strain", "stress", "velocity", "contact"});
  color_box_->setCurrentIndex(-1);
  color_box_->setToolTip("What the colour of the bodies shows");
  connect(color_box_, QOverload<int>::of(&QComboBox::activated), this, [this](int index) {
    const QString quantity = color_box_->itemText(index);
    request("colour by " + quantity, [this, quantity] { link_->set_color_by(quantity); });
  });

  auto* choices = new QWidget;
  auto* form = new QFormLayout(choices);
  form->setContentsMargins(0, 0, 0, 0);
  form->setSpacing(4);
  form->addRow("Node", node_box_);
  form->addRow("Scene", scene_row);
  form->addRow("Colour by", color_box_);
  return choices;
}

QWidget* SimulationView::make_buttons() {
  play_ = button("play", "Play", "Let time run");
  pause_ = button("pause", "Pause", "Stop time");
  step_ = button("step", "Step", "Make one step");
  step_10_ = button("step_10", "10 steps", "Make ten steps");
  reset_ = button("reset", "Reset", "Back to the initial state of the scene");
  connect(play_, &QPushButton::clicked, this, [this] { request("play", [this] { link_->set_paused(false); }); });
  connect(pause_, &QPushButton::clicked, this, [this] { request("pause", [this] { link_->set_paused(true); }); });
  connect(step_, &QPushButton::clicked, this, [this] { request("step", [this] { link_->step(1); }); });
  connect(step_10_, &QPushButton::clicked, this, [this] { request("10 steps", [this] { link_->step(10); }); });
  connect(reset_, &QPushButton::clicked, this, [this] { request("reset", [this] { link_->reset(); }); });
  auto* buttons = new QWidget;
  auto* row = new QHBoxLayout(buttons);
  row->setContentsMargins(0, 0, 0, 0);
  row->setSpacing(4);
  for (QPushButton* each : {play_, pause_, step_, step_10_, reset_}) row->addWidget(each, 1);
  return buttons;
}

void SimulationView::connect_link() {
  connect(link_, &SimulationLink::status_received, this, &SimulationView::on_status);
  connect(link_, &SimulationLink::grasps_received, this,
          [this](const QString& node, const GraspStateArrayConstPtr& grasps) {
            if (node == node_) readings_->add(grasps);
          });
  connect(link_, &SimulationLink::color_by_received, this, &SimulationView::on_color_by);
  connect(link_, &SimulationLink::answered, this, &SimulationView::on_answer);
  connect(link_, &SimulationLink::nodes_found, this, &SimulationView::on_nodes);
  connect(link_, &SimulationLink::scenes_found, this, &SimulationView::on_scenes);
}

// --- which node
// -------------------------------------------------------------------------------------------------------

void SimulationView::set_node(const QString& name) {
  const QString node = name.startsWith('/') ? name : "/" + name;
  if (!is_node_name(name) || node == node_) {
    node_box_->setEditText(node_);
    return;
  }
  node_ = node;
  node_box_->setEditText(node_);
  if (isVisible()) reopen();
  Q_EMIT node_changed();
}

void SimulationView::showEvent(QShowEvent* event) {
  QWidget::showEvent(event);
  if (event->spontaneous()) return;  // only minimised
  reopen();
  link_->look_around();
  timer_.start(kRefreshPeriod);
}

void SimulationView::hideEvent(QHideEvent* event) {
  QWidget::hideEvent(event);
  if (event->spontaneous()) return;
  timer_.stop();
  link_->close();
}

void SimulationView::reopen() {
  readings_->clear();
  color_box_->setCurrentIndex(-1);
  asked_.clear();
  message_->hide();
  silent_ = true;
  heard_.start();
  connection_->setText("connecting to " + node_ + " ...");
  connection_->show();
  lock_controls(false);
  link_->open(node_);
}

void SimulationView::tick() {
  readings_->refresh();
  if (++ticks_ % kLookPeriod == 0) link_->look_around();
  // A request under way may keep the node busy; it has a deadline of its own.
  if (heard_.elapsed() < kSilence || !asked_.isEmpty()) return;
  heard_.start();
  silent_ = true;
  connection_->setText("no answer from " + node_);
  connection_->show();
  lock_controls(false);
  link_->open(node_);  // there may be a master, or a node, only now
}

// --- what is asked
// ----------------------------------------------------------------------------------------------------

template <class Ask>
void SimulationView::request(const QString& what, Ask ask) {
  asked_ = what;
  say(what + " ...", false);
  lock_controls(true);
  ask();
}

void SimulationView::lock_controls(bool locked) {
  for (QWidget* control : std::initializer_list<QWidget*>{load_, color_box_, step_, step_10_, reset_}) {
    control->setEnabled(!locked);
  }
  // While it is not known whether time runs, both can be asked for.
  play_->setEnabled(!locked && (silent_ || paused_));
  pause_->setEnabled(!locked && (silent_ || !paused_));
}

void SimulationView::say(const QString& text, bool problem) {
  message_->setText(text);
  QPalette colors = palette();
  if (problem) colors.setColor(QPalette::WindowText, QColor(176, 32, 24));
  message_->setPalette(colors);
  message_->show();
}

void SimulationView::choose_scene_file() {
  const QString file = QFileDialog::getOpenFileName(this, "Scene", QString(), "Scenes (*.yaml);;All files (*)");
  if (!file.isEmpty()) scene_box_->setEditText(file);
}

// --- what is heard
// ----------------------------------------------------------------------------------------------------

void SimulationView::on_status(const QString& node, const SimStatusConstPtr& status) {
  if (node != node_) return;
  readings_->add(status);
  heard_.start();
  if (silent_ || paused_ != (status->paused != 0)) {
    silent_ = false;
    paused_ = status->paused != 0;
    lock_controls(!asked_.isEmpty());
  }
  connection_->setText(paused_ ? "paused" : "");
  connection_->setVisible(paused_);
}

void SimulationView::on_color_by(const QString& node, const QString& quantity) {
  if (node == node_) color_box_->setCurrentIndex(color_box_->findText(quantity));
}

void SimulationView::on_answer(const QString& node, bool accepted, const QString& message) {
  if (node != node_ || asked_.isEmpty()) return;
  const QString what = asked_;
  asked_.clear();
  lock_controls(false);
  say(what + (accepted ? ": done" : ": refused") + (message.isEmpty() ? "" : "; " + message), !accepted);
}

void SimulationView::on_nodes(const QStringList& nodes) {
  replace_items(node_box_, nodes);
}

void SimulationView::on_scenes(const QStringList& names) {
  replace_items(scene_box_, names);
}

}  // namespace deformable_sim
