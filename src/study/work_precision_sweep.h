// All configurations of a plan, cheap ones first, as far as the budget goes.
#pragma once

#include "deformable_sim/scene/progress.h"
#include "work_precision_budget.h"
#include "work_precision_errors.h"
#include "work_precision_plan.h"
#include "work_precision_store.h"

namespace deformable_sim::work_precision {

/// What a sweep works with; nothing is owned.
struct Bench {
  const Case* subject;
  const Yardstick* yardstick;
  const Reference* reference;
  double tight;         // m/s^2, Newton tolerance of converged solves
  double verlet_step;   // s, that velocity Verlet can use
  double most_per_run;  // CPU s
  double until;         // CPU s of the budget
  const Budget* budget;
  RunLog* log;
  Progress* progress;
};

class Sweep {
 public:
  explicit Sweep(const Bench& bench) : bench_(bench) {}
  void go(const std::vector<Family>& families);
  const std::vector<Row>& rows() const { return rows_; }
  const std::vector<std::string>& left_out() const { return left_out_; }

 private:
  struct Lane {
    Family family;
    size_t next = 0;
    std::vector<Row> rows;
    double probed = 0.0;  // CPU s of a run of an explicit scheme
  };
  /// CPU s of the next run of a lane.
  double expected(const Lane& lane) const;
  Row find_row(const Configuration& k);
  Row measure(const Configuration& k);
  const Row* known(const Configuration& k) const;
  /// The same scheme and step with converged Newton; null where it costs too much or diverged.
  const Trajectory* base(const Configuration& k);
  void give_up(const Lane& lane, const std::string& why);

  Bench bench_;
  std::vector<Lane> lanes_;
  std::vector<Row> rows_;
  std::vector<Configuration> bases_;        // families that can be one
  std::map<std::string, Trajectory> base_;  // by scheme and steps
  double spent_on_bases_ = 0.0;             // CPU s
  std::vector<std::string> left_out_;
};

}  // namespace deformable_sim::work_precision
