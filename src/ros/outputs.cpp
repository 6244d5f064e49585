#include "deformable_sim/ros/outputs.h"

#include <utility>

#include "deformable_sim/ros/publishers/makers.h"
#include "deformable_sim/ros/publishers/registry.h"

namespace deformable_sim {

namespace {

constexpr double kHandlesPeriod = 0.1;    // s
constexpr double kRepeatPeriod = 1.0;     // s; also of diagnostics (REP 107)
constexpr double kShortestPeriod = 1e-3;  // s

double period_of(double hertz) {
  return hertz > 0.0 ? std::max(kShortestPeriod, 1.0 / hertz) : 0.0;
}

double period_of(Rate rate, const OutputSpec& outputs, const Parameters& parameters) {
  double hertz = 0.0;
  switch (rate) {
    case Rate::kMarkers:
      hertz = parameters.rate_markers.value_or(outputs.rate_markers);
      break;
    case Rate::kPoints:
      hertz = parameters.rate_points.value_or(outputs.rate_points);
      break;
    case Rate::kState:
      hertz = parameters.rate_state.value_or(outputs.rate_state);
      break;
    case Rate::kHandles:
      return kHandlesPeriod;
    case Rate::kDiagnostics:
      return kRepeatPeriod;
  }
  return period_of(hertz);
}

}  // namespace

std::shared_ptr<PublisherSet> make_publishers(const PublisherContext& context, const Parameters& parameters) {
  auto set = std::make_shared<PublisherSet>();
  for (const PublisherEntry& entry : publisher_registry()) {
    set->entries.push_back({entry.make(context), period_of(entry.rate, context.outputs, parameters), entry.repeats});
  }
  const auto ids = std::make_shared<SegmentIds>();
  for (const CameraParameters& camera : parameters.cameras) {
    // Repeated, for its frame may have moved, or be known at last.
    set->entries.push_back({make_camera_publisher(context, camera, ids), period_of(camera.rate), true});
  }
  return set;
}

Outputs::Outputs() : thread_([this] { publish_loop(); }) {}

Outputs::~Outputs() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stopping_ = true;
  }
  arrived_.notify_all();
  thread_.join();
}

void Outputs::use(std::shared_ptr<PublisherSet> publishers) {
  publishers_ = std::move(publishers);
  due_.assign(publishers_->entries.size(), Due());
  now_.assign(publishers_->entries.size(), false);
}

bool Outputs::is_due(const PublisherSet::Entry& entry, const Due& due, double time, double dt, std::uint64_t version,
                     Motion motion, bool* later) const {
  if (entry.period <= 0.0) return false;
  if (motion == Motion::kRunning) {
    if (due.next > time + entry.period) return true;  // time was set back
    return due.next <= time + 1e-6 * dt;
  }
  if (entry.publisher->joined() != due.joined) return true;
  const double age = std::chrono::duration<double>(Clock::now() - due.shown).count();
  if (version != due.version) {
    *later = true;
    return age >= entry.period;
  }
  return entry.repeats && age >= kRepeatPeriod;
}

/// Whether any publisher `asks`, of what is due now and of what the publishing thread has not come to: the next letter
/// stands in for that one too.
template <class Asks>
bool Outputs::any_due(const Asks& asks) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const bool waits = letter_ && letter_->publishers == publishers_;
  for (std::size_t i = 0; i < now_.size(); ++i) {
    const bool due = now_[i] || (waits && letter_->due[i]);
    if (due && asks(*publishers_->entries[i].publisher)) return true;
  }
  return false;
}

bool Outputs::offer(const World& world, std::uint64_t version, Motion motion, const std::function<Instant()>& run) {
  const double time = world.time();
  const double dt = world.settings().dt;
  bool any = false;
  bool later = false;
  for (std::size_t i = 0; i < due_.size(); ++i) {
    const PublisherSet::Entry& entry = publishers_->entries[i];
    Due& due = due_[i];
    now_[i] = false;
    bool pending = false;
    const bool is = is_due(entry, due, time, dt, version, motion, &pending);
    if (!is && !pending) continue;
    // Whether anybody listens is asked no more often than they would be told something.
    if (is && motion == Motion::kRunning) {
      due.next += entry.period;
      if (due.next <= time || due.next > time + entry.period) due.next = time + entry.period;
    }
    if (!entry.publisher->wanted()) continue;
    if (!is) {
      later = true;
      continue;
    }
    now_[i] = any = true;
    due.version = version;
    due.joined = entry.publisher->joined();
    due.shown = Clock::now();
  }
  if (!any) return later;
  auto instant = std::make_shared<Instant>(run());
  const bool reports = any_due([](const Publisher& p) { return p.detail() == SnapshotDetail::kReports; });
  instant->snapshot = world.snapshot(reports ? SnapshotDetail::kReports : SnapshotDetail::kMotion);
  if (any_due([](const Publisher& p) { return p.shows_contacts(); })) {
    instant->snapshot.contacts = world.contact_reports();
  }
  instant->warnings.insert(instant->warnings.begin(), instant->snapshot.warnings.begin(),
                           instant->snapshot.warnings.end());
  ++snapshots_;
  send({publishers_, std::move(instant), now_});
  return later;
}

void Outputs::send(Letter letter) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (letter_ && letter_->publishers == letter.publishers) {
      for (std::size_t i = 0; i < letter.due.size(); ++i) letter.due[i] = letter.due[i] || letter_->due[i];
    }
    letter_ = std::make_unique<Letter>(std::move(letter));
  }
  arrived_.notify_one();
}

void Outputs::publish_loop() {
  while (true) {
    Letter letter;
    {
      std::unique_lock<std::mutex> lock(mutex_);
      arrived_.wait(lock, [this] { return stopping_ || letter_; });
      if (stopping_) return;
      letter = std::move(*letter_);
      letter_.reset();
    }
    for (std::size_t i = 0; i < letter.due.size(); ++i) {
      if (letter.due[i]) letter.publishers->entries[i].publisher->publish(*letter.instant);
    }
  }
}

}  // namespace deformable_sim
