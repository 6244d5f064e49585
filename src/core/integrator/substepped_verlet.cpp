// Velocity Verlet in parts as short as the body asks for, within one step of the world.
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "deformable_sim/core/error.h"
#include "deformable_sim/core/integrator/impulse_contacts.h"
#include "deformable_sim/core/integrator/mesh_motion.h"
#include "deformable_sim/core/integrator/schemes.h"
#include "deformable_sim/core/integrator/sheet_motion.h"

namespace deformable_sim {
namespace {

constexpr int kRemeasureSteps = 500;  // springs: a limit changes little while the rest shape is the same
// Of a body that bends and is squeezed it falls. (omega h)^2 of the last part's motion, over the 4 at which parts
// become unstable: certainly outdated, and worth another look.
constexpr double kCertain = 1.0, kSuspect = 0.1;
constexpr int kSuspectSteps = 10, kMostTries = 3;
constexpr int kMostParts = 100000;

/// Kick h/2; drift h, kick h, ...; drift h, kick h/2. Damping acts with the velocity in the middle of a part, drag per
/// mass semi-implicitly. Sheets on grids move in rows (SheetMotion), other nodes with springs in packets (MeshMotion);
/// all other nodes, and terms that are none of these nor proportional to mass, as in the generic schemes.
///
/// Quadratic bending of a mesh has six times as many links as there are springs: most act in every few parts only
/// (LinkSplit).
template <class Real>
class SubsteppedVerlet : public Integrator {
 public:
  explicit SubsteppedVerlet(double fraction) : fraction_(fraction), parts_scheme_(make_symplectic_euler()) {}

  std::string name() const override { return "substepped_verlet"; }
  Needs needs() const override { return {false, true}; }
  int order() const override { return 2; }
  int order_with_velocity_forces() const override { return 1; }
  double stability_limit(double) const override { return std::numeric_limits<double>::infinity(); }
  void reset() override {
    prepared_ = false;
    measured_ago_ = kRemeasureSteps;
  }

  StepReport advance(double dt, Dynamics* d, State* s) override {
    measure(*d, *s);
    if (!prepared_) prepare(*d);
    StepReport report;
    for (int tries = 1;; ++tries) {
      begin(dt, *d, *s);
      take_parts(dt, d);
      report.force_evaluations += count_ + 1;
      if (others_.empty() || tries == kMostTries || !limit_has_fallen(*d, *s)) break;
    }
    finish(dt, d, s);
    // Still too long for where they led, which is stiffer than where they began: no step.
    const bool outgrown = !others_.empty() && sharpness_ > kCertain;
    report.converged = s->finite() && !outgrown;
    if (outgrown) report.residual = std::numeric_limits<double>::infinity();
    if (!report.converged) measured_ago_ = kRemeasureSteps;
    return report;
  }

 private:
  /// Sorts the terms and lays out the sheets.
  void prepare(const Dynamics& d) {
    prepared_ = true;
    const Eigen::Index n = d.mass->size();
    inverse_mass_ = d.mass->cwiseInverse();
    for (int node : d.kinematics.node) inverse_mass_[node] = 0.0;
    sheets_.clear();
    sheet_of_.assign(static_cast<size_t>(n), -1);
    std::vector<const Energy*> in_rows;
    if (d.grids != nullptr) {
      for (const GridSheet& grid : *d.grids) {
        for (int k = 0; k < grid.node_count(); ++k) {
          sheet_of_[static_cast<size_t>(grid.first_node + k)] = static_cast<int>(sheets_.size());
        }
        sheets_.push_back(
            std::make_unique<SheetMotion<Real>>(grid, *d.mass, d.kinematics.node, simd_level(), d.workers));
        in_rows.insert(in_rows.end(), grid.replaces.begin(), grid.replaces.end());
      }
    }
    everywhere_ = MassForce();
    weight_.setZero(3, n);
    work_.x = work_.v = Nodes::Zero(3, n);
    others_.clear();
    for (const Energy* energy : d.energies) {
      if (const MassForce* force = energy->mass_force()) {
        everywhere_.acceleration += force->acceleration;
        everywhere_.rate += force->rate;
        energy->add_force(work_, &weight_);  // angles of rods have none
      } else if (std::find(in_rows.begin(), in_rows.end(), energy) == in_rows.end()) {
        others_.push_back(energy);
      }
    }
    lay_out_mesh(d);
    rest_.clear();
    for (int i = 0; i < n; ++i) {
      if (sheet_of_[static_cast<size_t>(i)] < 0 && !in_mesh(i)) rest_.push_back(i);
    }
  }

  /// Where other terms have more to do than springs (rods), packets would only add the way there and back.
  void lay_out_mesh(const Dynamics& d) {
    mesh_.reset();
    split_ = LinkSplit();
    std::vector<const Energy*> left = others_;
    const SpringTerms springs = take_springs(&left);
    size_t elements = 0;
    for (const Energy* energy : left) elements += static_cast<size_t>(energy->element_count());
    if (springs.springs.empty() || springs.springs.size() < elements) return;
    others_.swap(left);
    split_ = split_links(springs.links, *d.mass, fraction_ * stable_dt_);
    mesh_ = std::make_unique<MeshMotion<Real>>(springs, *d.mass, d.kinematics.node, split_);
  }

  bool in_mesh(int node) const { return mesh_ != nullptr && mesh_->contains(node); }

  /// Parts are leaps with damping that lags by half a part: stable as long as symplectic Euler is.
  void measure(const Dynamics& d, const State& s) {
    if (measured_ago_++ < kRemeasureSteps) return;
    measured_ago_ = 1;
    stable_dt_ = stable_step(*parts_scheme_, highest_frequency(d, s), highest_damping_rate(d, s));
  }

  void take_parts(double dt, Dynamics* d) {
    const double parts = std::clamp(std::ceil(dt / (fraction_ * stable_dt_) - 1e-9), 1.0, 1.0 * kMostParts);
    const auto count = static_cast<int>(parts);
    const double h = dt / parts;
    find_link_parts(h, count);
    leap(0.5 * h, h, 0.0, dt, d);
    for (part_ = 1; part_ < count; ++part_) leap(h, h, part_ * h, dt, d);
    if (!others_.empty()) last_force_ = force_;
    leap(0.5 * h, 0.0, dt, dt, d);
  }

  /// (omega h)^2 / 4 of the last part's motion by Rayleigh's quotient, which is a lower bound of the highest: dx = h v,
  /// df the change of the forces over it. Springs in packets are left out, and grow no stiffer.
  double find_sharpness() const {
    double stiff = 0.0, inert = 0.0;
    for (Eigen::Index i = 0; i < inverse_mass_.size(); ++i) {
      if (!(inverse_mass_[i] > 0.0)) continue;
      stiff += (last_force_.col(i) - force_.col(i)).dot(work_.v.col(i));
      inert += work_.v.col(i).squaredNorm() / inverse_mass_[i];
    }
    return inert == 0.0 ? 0.0 : 0.25 * part_length_ * stiff / inert;
  }

  /// Measures again from the start of a step whose motion is as sharp as its parts can bear, or no number. True: the
  /// parts were too long, and the step is to be taken again.
  bool limit_has_fallen(const Dynamics& d, const State& start) {
    if (sharpness_ < (measured_ago_ < kSuspectSteps ? kCertain : kSuspect)) return false;
    measured_ago_ = kRemeasureSteps;
    measure(d, start);
    return part_length_ > (1.0 + 1e-6) * fraction_ * stable_dt_;
  }

  /// In which of the parts of length h slow links act: every so many.
  void find_link_parts(double h, int count) {
    part_ = 0;
    count_ = count;
    together_ = std::clamp(static_cast<int>(split_.longest / h), 1, split_.together);
    part_length_ = h;
  }
  /// s, of the present part.
  double slow_kick() const {
    if (part_ % together_ != 0 && part_ != count_) return 0.0;
    const int before = part_ == 0 ? 0 : part_ - (part_ - 1) / together_ * together_;
    const int after = std::min(together_, count_ - part_);
    return 0.5 * part_length_ * (before + after);
  }

  void begin(double dt, const Dynamics& d, const State& s) {
    work_.x = s.x;
    work_.v = s.v;
    work_.time = start_time_ = s.time;
    work_.copy_frames(s);
    const Kinematics& k = d.kinematics;
    held_force_.setZero(3, static_cast<Eigen::Index>(k.node.size()));
    held_v_.resize(3, held_force_.cols());
    mesh_impulse_.setZero(3, held_force_.cols());
    for (Eigen::Index i = 0; i < held_force_.cols(); ++i) {
      const int node = k.node[static_cast<size_t>(i)];
      held_v_.col(i) = s.v.col(node);
      work_.v.col(node) = (k.target.col(i) - s.x.col(node)) / dt;
    }
    for (auto& sheet : sheets_) sheet->load(work_.x, work_.v, dt);
    if (mesh_ != nullptr) mesh_->load(work_, dt);
    impulse_.assign(d.contacts.size(), Vec3::Zero());
    if (!d.contacts.empty()) find_contact_nodes(d);
  }

  /// A kick at `time` (s from the start of the step) and the drift after it.
  void leap(double kick, double drift, double time, double dt, Dynamics* d) {
    work_.time = start_time_ + time;
    const Nodes* more = others_.empty() ? nullptr : &force_;
    if (more != nullptr) {
      if (time > 0.0) {
        for (auto& sheet : sheets_) sheet->store(&work_.x, &work_.v);
        if (mesh_ != nullptr) mesh_->store(&work_.x, &work_.v);
      }
      force_.setZero(3, work_.x.cols());
      for (const Energy* energy : others_) energy->add_force(work_, &force_);
      if (drift == 0.0) sharpness_ = find_sharpness();  // before the kick, with the velocity that led here
    }
    for (auto& sheet : sheets_) {
      sheet->leap(kick, drift, everywhere_, more);
      sheet->add_held_forces(kick / dt, &held_force_);
    }
    if (mesh_ != nullptr) mesh_->leap(kick, slow_kick(), drift, everywhere_, more, &mesh_impulse_);
    leap_rest(kick, drift, dt, *d);
    if (!d->contacts.empty()) resolve_contacts(kick, drift, dt - time - drift, d);
  }

  void leap_rest(double kick, double drift, double dt, const Dynamics& d) {
    if (rest_.empty()) return;
    const double half = 0.5 * everywhere_.rate * kick;
    for (int i : rest_) {
      const double w = inverse_mass_[i];
      if (w > 0.0) {
        work_.v.col(i) += kick / (1.0 + half) * (w * weight_.col(i) - everywhere_.rate * work_.v.col(i));
        if (!others_.empty()) work_.v.col(i) += kick / (1.0 + half) * w * force_.col(i);
      }
      work_.x.col(i) += drift * work_.v.col(i);
    }
    if (others_.empty()) return;
    for (Eigen::Index i = 0; i < held_force_.cols(); ++i) {
      const int node = d.kinematics.node[static_cast<size_t>(i)];
      if (sheet_of_[static_cast<size_t>(node)] < 0 && !in_mesh(node))
        held_force_.col(i) += kick / dt * force_.col(node);
    }
  }

  /// Contacts see the few nodes they name, gathered.
  void find_contact_nodes(const Dynamics& d) {
    near_.clear();
    passes_ = 1;
    contacts_ = d.contacts;
    place_of_.resize(sheet_of_.size(), -1);
    for (ContactConstraint& c : contacts_) {
      for (size_t k = 0; k < static_cast<size_t>(c.count); ++k) {
        int& place = place_of_[static_cast<size_t>(c.node[k])];
        if (place < 0) {
          place = static_cast<int>(near_.size());
          near_.push_back(c.node[k]);
        } else {
          passes_ = ImpulseContacts::kPasses;
        }
        c.node[k] = place;
      }
    }
    // Room for more than there are is never given back: their number changes from step to step.
    const auto count = static_cast<Eigen::Index>(near_.size());
    if (near_inverse_mass_.size() < count) {
      near_inverse_mass_.resize(2 * count);
      near_state_.x.resize(3, 2 * count);
      near_state_.v.resize(3, 2 * count);
    }
    for (size_t k = 0; k < near_.size(); ++k) {
      near_inverse_mass_[static_cast<Eigen::Index>(k)] = inverse_mass_[near_[k]];
      place_of_[static_cast<size_t>(near_[k])] = -1;
    }
  }

  /// Planes are given for the end of the step, `remaining` (s) from now. After the last kick no drift follows: what
  /// would cross in the next part is stopped.
  void resolve_contacts(double kick, double drift, double remaining, Dynamics* d) {
    for (size_t i = 0; i < contacts_.size(); ++i) {
      const ContactConstraint& c = d->contacts[i];
      contacts_[i].offset = c.offset - remaining * c.normal.dot(c.surface_velocity);
    }
    for (size_t k = 0; k < near_.size(); ++k) {
      const int node = near_[k], sheet = sheet_of_[static_cast<size_t>(node)];
      Vec3 x = work_.x.col(node), v = work_.v.col(node);
      if (sheet >= 0) sheets_[static_cast<size_t>(sheet)]->get(node, &x, &v);
      if (in_mesh(node)) mesh_->get(node, &x, &v);
      near_state_.x.col(static_cast<Eigen::Index>(k)) = x;
      near_state_.v.col(static_cast<Eigen::Index>(k)) = v;
    }
    if (drift > 0.0) {
      impulses_.resolve(contacts_, near_inverse_mass_, drift, 1.0, &near_state_, passes_);
    } else {
      impulses_.resolve(contacts_, near_inverse_mass_, 2.0 * kick, 0.0, &near_state_, passes_);
    }
    for (size_t k = 0; k < near_.size(); ++k) {
      const int node = near_[k], sheet = sheet_of_[static_cast<size_t>(node)];
      if (near_inverse_mass_[static_cast<Eigen::Index>(k)] == 0.0) continue;
      const Vec3 x = near_state_.x.col(static_cast<Eigen::Index>(k)),
                 v = near_state_.v.col(static_cast<Eigen::Index>(k));
      if (sheet >= 0) {
        sheets_[static_cast<size_t>(sheet)]->set(node, x, v);
      } else if (in_mesh(node)) {
        mesh_->set(node, x, v);
      } else {
        work_.x.col(node) = x;
        work_.v.col(node) = v;
      }
    }
    for (size_t i = 0; i < contacts_.size(); ++i) impulse_[i] += impulses_.impulse(i, contacts_);
  }

  void finish(double dt, Dynamics* d, State* s) {
    for (auto& sheet : sheets_) sheet->store(&work_.x, &work_.v);
    if (mesh_ != nullptr) mesh_->store(&work_.x, &work_.v);
    held_force_ += mesh_impulse_ / dt;
    Kinematics& k = d->kinematics;
    k.reaction.resize(3, held_force_.cols());
    for (Eigen::Index i = 0; i < held_force_.cols(); ++i) {
      const int node = k.node[static_cast<size_t>(i)];
      const double m = (*d->mass)[node];
      const Vec3 v = (k.target.col(i) - s->x.col(node)) / dt;
      work_.x.col(node) = k.target.col(i);
      work_.v.col(node) = v;
      k.reaction.col(i) =
          m / dt * (v - held_v_.col(i)) - held_force_.col(i) - weight_.col(node) + m * everywhere_.rate * v;
    }
    for (size_t i = 0; i < d->contacts.size(); ++i) d->contacts[i].force = impulse_[i] / dt;
    std::swap(s->x, work_.x);
    std::swap(s->v, work_.v);
    s->time += dt;
  }

  double fraction_;  // of the limit
  std::unique_ptr<Integrator> parts_scheme_;
  bool prepared_ = false;
  int measured_ago_ = kRemeasureSteps;
  double stable_dt_ = 0.0;
  std::vector<const Energy*> others_;
  MassForce everywhere_;
  Nodes weight_;                  // N, of all nodes: everywhere_ without its drag
  Eigen::VectorXd inverse_mass_;  // 0 at held nodes
  std::vector<std::unique_ptr<SheetMotion<Real>>> sheets_;
  std::vector<int> sheet_of_;               // by node, -1: none
  std::unique_ptr<MeshMotion<Real>> mesh_;  // null: no springs but those of sheets
  LinkSplit split_;
  int together_ = 1;          // parts between two impulses of slow links
  int part_ = 0, count_ = 0;  // the present part, and how many there are
  double part_length_ = 0.0;  // s
  std::vector<int> rest_;     // nodes of no sheet and of no mesh

  State work_;
  double start_time_ = 0.0;
  Nodes force_, last_force_;   // of others_, all nodes; a part before the end of the step
  double sharpness_ = 0.0;     // of the last part, see find_sharpness()
  Nodes mesh_impulse_;         // N s so far, of held nodes of the mesh
  Nodes held_force_, held_v_;  // of held nodes: mean force of terms that are no MassForce; velocity at the start

  ImpulseContacts impulses_;
  ContactConstraints contacts_;  // nodes counted within near_
  std::vector<int> near_, place_of_;
  int passes_ = 1;
  Eigen::VectorXd near_inverse_mass_;
  State near_state_;
  std::vector<Vec3> impulse_;  // N s so far, by contact
};

}  // namespace

std::unique_ptr<Integrator> make_substepped_verlet(const SolverSettings& settings) {
  const double fraction = settings.fraction_of_limit;
  if (!(fraction > 0.0 && fraction <= 0.95)) throw InputError("fraction_of_limit must be > 0 and at most 0.95");
  if (settings.precision == SolverSettings::Precision::kSingle)
    return std::make_unique<SubsteppedVerlet<float>>(fraction);
  return std::make_unique<SubsteppedVerlet<double>>(fraction);
}

}  // namespace deformable_sim
