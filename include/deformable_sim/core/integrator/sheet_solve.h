// Newton's method for a stage of one sheet on a grid, all in rows.
#pragma once

#include <memory>
#include <vector>

#include "deformable_sim/core/energy/limit_springs.h"
#include "deformable_sim/core/energy/terms.h"
#include "deformable_sim/core/grid/sheet_system.h"
#include "deformable_sim/core/integrator/stage_solver.h"

namespace deformable_sim {

/// What acts on sheets beside their own springs and bending.
struct SheetSurroundings {
  MassForce everywhere;
  std::vector<const TargetSprings*> targets;
  std::vector<const LimitSprings*> limits;
};

/// The method of ImplicitStage (same line search and tolerance, another start) for the nodes of one sheet: residual in
/// double precision by kernels, linear systems by SheetSystem.
class SheetSolve {
 public:
  SheetSolve(const GridSheet& sheet, const Dynamics& d, const SolverSettings& settings);

  StepReport solve(const StageEquation& equation, const State& start, const Dynamics& d,
                   const SheetSurroundings& around);
  /// f := the terms' force, in this sheet's columns.
  void find_force(const State& s, const SheetSurroundings& around, Nodes* f);
  /// Into this sheet's columns: x and v at the stage; the terms' force; M a - f - more_force, of held nodes only.
  void store(State* end, Nodes* force, Nodes* outer_force);
  void report_contacts(ContactConstraints* contacts);

 private:
  /// A node on which something acts beside springs, bending and weight.
  struct Touched {
    int node;  // of the sheet
    std::ptrdiff_t place;
    bool near;  // a contact names it
  };
  struct Sums {
    double squares = 0.0, work = 0.0;  // see SheetResidualSums
  };

  void begin(const StageEquation& equation, const State& start, const Dynamics& d, const SheetSurroundings& around);
  void find_touched(const Dynamics& d, const SheetSurroundings& around);
  int touch(int node);
  void set_formula();
  void set_target();
  void follow_implicit_euler(std::ptrdiff_t place, int node);
  double start_iteration();
  void evaluate(bool along_step);
  void gather();
  void add_terms(Nodes* f) const;
  void add_touched(bool along_step);
  bool is_rough(const StepReport& report) const;
  double unbalanced() const;
  void couple();
  void search_along_step();
  void try_fraction(double fraction);
  void push_out();
  Vec3 at(Xyz<double> rows, std::ptrdiff_t place) const { return {rows.x[place], rows.y[place], rows.z[place]}; }
  static void put(Xyz<double> rows, std::ptrdiff_t place, const Vec3& value);

  void advance(double fraction);

  SolverSettings settings_;
  BandLoop bands_;
  SheetRows<double> rows_;
  const StageKernels& kernels_;
  const SheetKernels& forces_;
  int first_, count_;
  std::vector<double> mass_;  // by node of the sheet
  struct Held {
    int node;
    size_t column;  // in Kinematics
  };
  Vec3 held_position(const Held& held) const;
  std::vector<Held> held_;
  std::unique_ptr<SheetSystem> system_;
  double free_count_;

  // The present stage.
  StageEquation equation_;
  const State* start_ = nullptr;
  const Dynamics* dynamics_ = nullptr;
  const SheetSurroundings* around_ = nullptr;
  XyzArray<double> x_, before_, base_, target_, v_, y_, force_;
  RowArray<double> mass_rows_, per_tau_, inertia_;
  double formula_tau_ = 0.0, formula_rate_ = -1.0;
  std::vector<std::ptrdiff_t> off_formula_;  // places where per_tau_ and inertia_ are others
  SheetResidual residual_{};
  Sums sums_, base_sums_;  // of all nodes; from kernels: squares of the untouched ones, work without contacts
  double slope_ = 0.0;
  int force_evaluations_ = 0;

  // Touched nodes, gathered.
  std::vector<Touched> touched_;
  std::vector<int> touched_of_;       // by node of the sheet, -1: none
  RowArray<float> untouched_weight_;  // 1/kg, 0 at touched and held nodes
  Nodes touched_x_, touched_start_, touched_force_, contact_force_;
  std::vector<Vec3> touched_base_;  // target + force - inertia x, without contacts
  Eigen::VectorXd touched_inverse_mass_;
  ContactConstraints constraints_;     // nodes counted within touched_
  std::vector<size_t> constraint_of_;  // in Dynamics::contacts
  PenaltyContacts contacts_;
};

}  // namespace deformable_sim
