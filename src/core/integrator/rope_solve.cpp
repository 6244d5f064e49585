#include "deformable_sim/core/integrator/rope_solve.h"

#include <algorithm>
#include <cmath>

namespace deformable_sim {
namespace {

constexpr int kMostSteps = 10;     // two or three are enough when they are good at all, as in ImplicitStage
constexpr double kHolding = 1e30;  // N/m: beside it no spring counts
constexpr double kContracting =
    0.5;                             // share of a step that the next one with the same factors is: below, they converge
constexpr double kMargin = 0.1;      // of the tolerance: what steps leave need not cancel from one to the next
constexpr double kShortest = 1e-12;  // m: shorter springs have no direction
constexpr double kAnyStep = 1.0;     // s

RopeChain::Spring spring_at(const std::vector<RopeChain::Spring>& springs, int k) {
  return k >= 0 && k < static_cast<int>(springs.size()) ? springs[static_cast<size_t>(k)] : RopeChain::Spring();
}

RopeChain::Joint joint_at(const RopeChain& chain, int k) {
  return k >= 0 && k < static_cast<int>(chain.joints.size()) ? chain.joints[static_cast<size_t>(k)]
                                                             : RopeChain::Joint();
}

Two swapped(Two a) {
  return Two{a[1], a[0]};
}

/// max(0, k (1 - L / r)).
Two transverse(const Two* d, Two stiffness, Two length) {
  const Two squared = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
  const Two r{std::sqrt(std::max(squared[0], kShortest * kShortest)),
              std::sqrt(std::max(squared[1], kShortest * kShortest))};
  const Two t = stiffness * (1.0 - length / r);
  return Two{std::max(t[0], 0.0), std::max(t[1], 0.0)};
}

/// Forces of springs and bending on single nodes.
struct ChainForces {
  const RopeChain& chain;
  const State& s;

  Vec3 on(int node) const { return flow(node) - flow(node - 1) + span(node) - span(node - 2); }

 private:
  Vec3 between(const Nodes& nodes, int a, int b) const {
    return nodes.col(chain.first_node + b) - nodes.col(chain.first_node + a);
  }
  Vec3 pull(const RopeChain::Spring& spring, int a, int b) const {
    const Vec3 d = between(s.x, a, b);
    const double r = d.norm();
    if (r < kShortest) return Vec3::Zero();
    return ((spring.stiffness * (r - spring.length) + spring.damping * d.dot(between(s.v, a, b)) / r) / r) * d;
  }
  Vec3 moment(int k) const {
    const RopeChain::Joint j = joint_at(chain, k);
    if (j.stiffness == 0.0) return Vec3::Zero();
    const auto curvature = [&](const Nodes& nodes) -> Vec3 {
      return j.before * between(nodes, k, k + 1) + j.behind * between(nodes, k + 1, k + 2);
    };
    return j.stiffness * (curvature(s.x) + j.damping * curvature(s.v));
  }
  /// Of link k and the joints at its ends, on its first node; the other one gets the opposite.
  Vec3 flow(int k) const {
    if (k < 0 || k + 1 >= chain.count) return Vec3::Zero();
    return pull(chain.links[static_cast<size_t>(k)], k, k + 1) + joint_at(chain, k).before * moment(k) +
           joint_at(chain, k - 1).behind * moment(k - 1);
  }
  Vec3 span(int k) const {
    if (k < 0 || k + 2 >= chain.count || chain.spans.empty()) return Vec3::Zero();
    return pull(chain.spans[static_cast<size_t>(k)], k, k + 2);
  }
};

}  // namespace

RopeSolve::RopeSolve(const RopeChain& chain, const Dynamics& d, const SolverSettings& settings,
                     const RopeSurroundings& around)
    : chain_(chain), settings_(settings), kernels_(rope_kernels(simd_level())) {
  mass_ = d.mass->segment(chain.first_node, chain.count);
  const auto mine = [&](int node) { return node >= chain.first_node && node < chain.first_node + chain.count; };
  for (size_t k = 0; k < d.kinematics.node.size(); ++k) {
    const int node = d.kinematics.node[k];
    if (mine(node)) held_.push_back({node - chain.first_node, static_cast<Eigen::Index>(k)});
  }
  for (const TargetSprings* springs : around.targets) {
    for (size_t k = 0; k < springs->nodes().size(); ++k) {
      const int node = springs->nodes()[k];
      if (mine(node)) soft_.push_back({node - chain.first_node, springs, static_cast<Eigen::Index>(k)});
    }
  }
  free_ = static_cast<double>(std::max(1, chain.count - static_cast<int>(held_.size())));
  system_.half = std::max(2, (chain.count + 1) / 2);
  lay_out();
}

/// What never changes: springs, and room for all else.
void RopeSolve::lay_out() {
  const int half = system_.half;
  places_.assign(static_cast<size_t>(half) + 2, RopePlace{});
  factors_.assign(static_cast<size_t>(half), RopeFactor{});
  if (!chain_.spans.empty()) spans_.assign(static_cast<size_t>(half), RopeSpan{});
  if (chain_.damped) damping_.assign(static_cast<size_t>(half), RopeDamping{});
  for (int k = 0; k < half; ++k) {
    const int other = 2 * half - 1 - k;
    RopePlace& p = places_[static_cast<size_t>(k)];
    const RopeChain::Spring a = spring_at(chain_.links, k), b = spring_at(chain_.links, other - 1);
    p.stiffness = Two{a.stiffness, b.stiffness};
    p.length = Two{a.length, b.length};
    const RopeChain::Joint i = joint_at(chain_, k), j = joint_at(chain_, other - 2);
    p.before = Two{i.before, -j.behind};
    p.behind = Two{i.behind, -j.before};
    p.mass = Two{k < chain_.count ? mass_[k] : 0.0, other < chain_.count ? mass_[other] : 0.0};
    if (spans_.empty()) continue;
    const RopeChain::Spring c = spring_at(chain_.spans, k), e = spring_at(chain_.spans, other - 2);
    spans_[static_cast<size_t>(k)] = {Two{c.stiffness, e.stiffness}, Two{c.length, e.length}, Two{}, {}, {}};
  }
  system_.place = places_.data();
  system_.factor = factors_.data();
  system_.span = spans_.empty() ? nullptr : spans_.data();
  system_.damping = damping_.empty() ? nullptr : damping_.data();
}

/// What depends on tau: inertia, the matrix of bending, dampers.
void RopeSolve::set_step(double tau, double rate) {
  if (tau == tau_ && rate == rate_) return;
  tau_ = tau;
  rate_ = rate;
  const int half = system_.half, n = chain_.count;
  std::vector<std::array<double, 3>>& band = band_;
  std::vector<double>& inertia = inertia_;
  band.assign(static_cast<size_t>(2 * half) + 2, {0.0, 0.0, 0.0});
  inertia.resize(band.size());
  for (int k = 0; k < n; ++k) band[static_cast<size_t>(k)][0] = mass_[k] * (1.0 / tau + rate) / tau;
  for (const Soft& s : soft_) band[static_cast<size_t>(s.node)][0] += s.springs->stiffness();
  for (size_t k = 0; k < inertia.size(); ++k) inertia[k] = band[k][0];
  for (int k = 0; k + 2 < n; ++k) {
    const RopeChain::Joint j = joint_at(chain_, k);
    const double b = j.stiffness * (1.0 + j.damping / tau), share[3] = {-j.before, j.before - j.behind, j.behind};
    for (int p = 0; p < 3; ++p) {
      for (int q = p; q < 3; ++q) {
        band[static_cast<size_t>(k + p)][static_cast<size_t>(q - p)] += b * share[p] * share[q];
      }
    }
  }
  for (const Held& h : held_) band[static_cast<size_t>(h.node)][0] = kHolding;
  for (int k = n; k < 2 * half; ++k) band[static_cast<size_t>(k)][0] = kHolding;
  for (int k = 0; k < half; ++k) {
    const int other = 2 * half - 1 - k;
    RopePlace& p = places_[static_cast<size_t>(k)];
    p.inertia = Two{inertia[static_cast<size_t>(k)], inertia[static_cast<size_t>(other)]};
    for (int t = 0; t < 3; ++t) {
      const auto at = static_cast<size_t>(t);
      p.band[t] = Two{band[static_cast<size_t>(k)][at], other >= t ? band[static_cast<size_t>(other - t)][at] : 0.0};
    }
    const RopeChain::Joint i = joint_at(chain_, k), j = joint_at(chain_, other - 2);
    p.moment = Two{i.stiffness * (1.0 + i.damping / tau), j.stiffness * (1.0 + j.damping / tau)};
    if (damping_.empty()) continue;
    RopeDamping& damping = damping_[static_cast<size_t>(k)];
    damping.link = Two{spring_at(chain_.links, k).damping, spring_at(chain_.links, other - 1).damping} / tau;
    damping.span = Two{spring_at(chain_.spans, k).damping, spring_at(chain_.spans, other - 2).damping} / tau;
    damping.bending = Two{i.stiffness * i.damping, j.stiffness * j.damping} / tau;
  }
}

bool RopeSolve::solve(const StageEquation& equation, const State& start, const Dynamics& d,
                      const RopeSurroundings& around, StepReport* report) {
  begin(equation, start, d, around);
  const double per_step = 1.0 / (std::sqrt(free_) * equation.tau * equation.tau);
  for (int k = 0; k < settings_.newton_iterations; ++k) {
    if (k == kMostSteps || !kernels_.factorise(&system_)) return false;
    const double first = std::sqrt(kernels_.move(&system_)) * per_step;
    kernels_.resume(&system_);
    const double second = std::sqrt(kernels_.move(&system_)) * per_step, share = second / first;
    ++report->newton_iterations;
    report->force_evaluations += 2;
    if (!std::isfinite(second)) return false;
    report->residual = share < kContracting ? second * share / (1.0 - share) : second;
    const double enough = share < kContracting ? kMargin * settings_.tolerance : settings_.tolerance;
    if (report->residual <= enough) break;
    if (share > 1.0) kernels_.take_back(&system_);
  }
  report->converged = report->residual <= settings_.tolerance;
  return true;
}

void RopeSolve::begin(const StageEquation& equation, const State& start, const Dynamics& d,
                      const RopeSurroundings& around) {
  set_step(equation.tau, around.everywhere.rate);
  if (!damping_.empty()) {
    load(*equation.x_base);
    set_bases();
  }
  guess(equation, start, around);
  place_held(equation, start, d.kinematics);
  copy_middle();
  add_soft();
}

/// The columns of a place's nodes; those that only fill up the places get those of the last node.
std::array<std::ptrdiff_t, 2> RopeSolve::columns(int place) const {
  const int last = chain_.count - 1;
  return {3 * static_cast<std::ptrdiff_t>(chain_.first_node + std::min(place, last)),
          3 * static_cast<std::ptrdiff_t>(chain_.first_node + std::min(2 * system_.half - 1 - place, last))};
}

void RopeSolve::load(const Nodes& nodes) {
  const double* from = nodes.data();
  for (int k = 0; k < system_.half; ++k) {
    const auto [a, b] = columns(k);
    for (int i = 0; i < 3; ++i) places_[static_cast<size_t>(k)].x[i] = Two{from[a + i], from[b + i]};
  }
  copy_middle();
}

void RopeSolve::copy_middle() {
  const auto half = static_cast<size_t>(system_.half);
  for (size_t t = 0; t < 2; ++t) {
    for (int i = 0; i < 3; ++i) places_[half + t].x[i] = swapped(places_[half - 1 - t].x[i]);
  }
}

/// In: x_base in places_.
void RopeSolve::set_bases() {
  for (size_t k = 0; k < damping_.size(); ++k) {
    RopeDamping& damping = damping_[k];
    const RopePlace* p = &places_[k];
    for (int i = 0; i < 3; ++i) {
      damping.link_base[i] = p[1].x[i] - p[0].x[i];
      damping.span_base[i] = p[2].x[i] - p[0].x[i];
      damping.moment[i] = damping.bending * (p->before * damping.link_base[i] + p->behind * (p[2].x[i] - p[1].x[i]));
    }
  }
}

/// The transverse stiffness of springs at the start; x at the end of a motion with the last acceleration known, or
/// none; and what the residual has at x = 0: M (a + rate v) - weight - more_force there, turned round.
void RopeSolve::guess(const StageEquation& equation, const State& start, const RopeSurroundings& around) {
  const double *x0 = start.x.data(), *x_base = equation.x_base->data(), *v_base = equation.v_base->data();
  const double* more = equation.more_force != nullptr ? equation.more_force->data() : nullptr;
  const bool known = start.v_before.cols() == start.v.cols() && start.dt_before > 0.0;
  const double *now = known ? start.v.data() : v_base, *before = known ? start.v_before.data() : v_base;
  const double lasting = known ? tau_ * tau_ / start.dt_before : 0.0;
  const double of_x = (1.0 / tau_ + rate_) / tau_, of_v = 1.0 / tau_;
  std::array<std::ptrdiff_t, 2> here = columns(0), next = columns(1);
  for (int k = 0; k < system_.half; ++k) {
    const auto behind = columns(k + 2);
    RopePlace& p = places_[static_cast<size_t>(k)];
    Two link[3], span[3];
    for (std::ptrdiff_t i = 0; i < 3; ++i) {
      const auto pair = [a = here[0] + i, b = here[1] + i](const double* from) { return Two{from[a], from[b]}; };
      const Two x = pair(x_base), v = pair(v_base), from = pair(x0);
      link[i] = Two{x0[next[0] + i], x0[next[1] + i]} - from;
      span[i] = Two{x0[behind[0] + i], x0[behind[1] + i]} - from;
      p.x[i] = x + tau_ * v + lasting * (pair(now) - pair(before));
      p.target[i] = p.mass * (of_x * x + of_v * v + around.everywhere.acceleration[i]);
      if (more != nullptr) p.target[i] += pair(more);
    }
    p.tension = transverse(link, p.stiffness, p.length);
    if (!spans_.empty()) {
      RopeSpan& s = spans_[static_cast<size_t>(k)];
      s.tension = transverse(span, s.stiffness, s.length);
    }
    here = next;
    next = behind;
  }
}

void RopeSolve::place_held(const StageEquation& equation, const State& start, const Kinematics& kinematics) {
  for (const Held& h : held_) {
    const Vec3 target = kinematics.target.col(h.column), x0 = start.x.col(column(h.node));
    const Vec3 x = equation.fraction == 1.0 ? target : Vec3(x0 + equation.fraction * (target - x0));
    const auto [place, lane] = seat(h.node);
    for (int i = 0; i < 3; ++i) places_[static_cast<size_t>(place)].x[i][lane] = x[i];
  }
}

void RopeSolve::add_soft() {
  for (const Soft& s : soft_) {
    const auto [place, lane] = seat(s.node);
    for (int i = 0; i < 3; ++i) {
      places_[static_cast<size_t>(place)].target[i][lane] += s.springs->stiffness() * s.springs->targets()(i, s.column);
    }
  }
}

/// Dampers see a step of any length that has led here with the velocities v.
void RopeSolve::find_force(const State& s, const RopeSurroundings& around, Nodes* f) {
  if (tau_ == 0.0) set_step(kAnyStep, around.everywhere.rate);
  const double *x = s.x.data(), *v = s.v.data();
  if (!damping_.empty()) {
    for (int k = 0; k < system_.half; ++k) {
      const auto [a, b] = columns(k);
      for (int i = 0; i < 3; ++i) {
        places_[static_cast<size_t>(k)].x[i] = Two{x[a + i] - tau_ * v[a + i], x[b + i] - tau_ * v[b + i]};
      }
    }
    copy_middle();
    set_bases();
  }
  const MassForce& everywhere = around.everywhere;
  for (int k = 0; k < system_.half; ++k) {
    const auto [a, b] = columns(k);
    RopePlace& p = places_[static_cast<size_t>(k)];
    for (int i = 0; i < 3; ++i) {
      p.x[i] = Two{x[a + i], x[b + i]};
      p.target[i] = p.mass * (everywhere.acceleration[i] - everywhere.rate * Two{v[a + i], v[b + i]});
    }
  }
  copy_middle();
  for (const Soft& soft : soft_) {
    const auto [place, lane] = seat(soft.node);
    const Vec3 force =
        soft.springs->stiffness() * (soft.springs->targets().col(soft.column) - s.x.col(column(soft.node)));
    for (int i = 0; i < 3; ++i) places_[static_cast<size_t>(place)].target[i][lane] += force[i];
  }
  kernels_.find_forces(&system_);
  for (int k = 0; k < system_.half; ++k) store(k, factors_[static_cast<size_t>(k)].rest, f->data());
}

void RopeSolve::store(int place, const Two* values, double* to) const {
  const auto [a, b] = columns(place);
  const bool first = place < chain_.count, second = 2 * system_.half - 1 - place < chain_.count;
  for (int i = 0; i < 3; ++i) {
    if (first) to[a + i] = values[i][0];
    if (second) to[b + i] = values[i][1];
  }
}

void RopeSolve::store(const StageEquation& equation, const RopeSurroundings& around, State* end, Nodes* force,
                      Nodes* outer_force) const {
  const double *x_base = equation.x_base->data(), per_tau = 1.0 / tau_;
  for (int k = 0; k < system_.half; ++k) {
    const auto [a, b] = columns(k);
    const Two* x = places_[static_cast<size_t>(k)].x;
    Two v[3];
    for (int i = 0; i < 3; ++i) v[i] = (x[i] - Two{x_base[a + i], x_base[b + i]}) * per_tau;
    store(k, x, end->x.data());
    store(k, v, end->v.data());
  }
  find_held_force(*end, around, force);
  for (const Held& h : held_) {
    const int c = column(h.node);
    outer_force->col(c) = mass_[h.node] / tau_ * (end->v.col(c) - equation.v_base->col(c)) - force->col(c);
    if (equation.more_force != nullptr) outer_force->col(c) -= equation.more_force->col(c);
  }
}

void RopeSolve::find_held_force(const State& s, const RopeSurroundings& around, Nodes* f) const {
  const ChainForces forces{chain_, s};
  for (const Held& h : held_) {
    const int c = column(h.node);
    f->col(c) =
        forces.on(h.node) + mass_[h.node] * (around.everywhere.acceleration - around.everywhere.rate * s.v.col(c));
  }
}

}  // namespace deformable_sim
