#include "deformable_sim/core/grid/sheet_system.h"

#include <cmath>

namespace deformable_sim {
namespace {

constexpr float kSweep =
    0.65f;  // weight of a block-Jacobi sweep: below 2/3, or the preconditioner need not be definite

std::array<float, 6> six_of(const Mat3& m) {
  const auto entry = [&](int row, int col) { return static_cast<float>(m(row, col)); };
  return {entry(0, 0), entry(0, 1), entry(0, 2), entry(1, 1), entry(1, 2), entry(2, 2)};
}

}  // namespace

SheetSystem::SheetSystem(const GridSheet& sheet, const std::vector<double>& mass, const std::vector<char>& free,
                         const Workers* workers)
    : bands_(Bands::of(sheet.rows, sheet.cols), workers),
      rows_(sheet, bands_.scratch_count()),
      kernels_(stage_kernels(simd_level())),
      multigrid_(sheet, mass, free, workers),
      damping_time_(sheet.damping_time),
      bending_damping_(sheet.bending_damping),
      springs_(sheet.rows, SheetMatrix::kNumbers * SheetMatrix::kSprings * rows_.shape().stride),
      inertia_(rows_.make_array()),
      free_(rows_.make_array()),
      weight_(rows_.make_array()),
      x_(rows_.make_xyz()),
      r_(rows_.make_xyz()),
      z_(rows_.make_xyz()),
      p_(rows_.make_xyz()),
      y_(rows_.make_xyz()),
      step_(rows_.make_xyz()) {
  SheetMatrix a{};
  a.springs = springs_.data();
  if (rows_.shape().has_flexion) {
    long_springs_ = {sheet.rows, SheetMatrix::kNumbers * SheetMatrix::kLongSprings * rows_.shape().stride};
    a.long_springs = long_springs_.data();
  }
  if (!sheet.bending.empty()) {
    pack_bending(sheet.bending);
    a.bending = bending_rows_.data();
  }
  for (size_t k = 0; k < inverse_.size(); ++k) {
    inverse_[k] = rows_.make_array();
    a.inverse[k] = inverse_[k].data();
  }
  for (int node = 0; node < rows_.node_count(); ++node) {
    const auto k = static_cast<size_t>(node);
    free_.data()[rows_.place(node)] = free[k] != 0 ? 1.0f : 0.0f;
    weight_.data()[rows_.place(node)] = free[k] != 0 ? static_cast<float>(1.0 / mass[k]) : 0.0f;
  }
  a.inertia = inertia_.data();
  a.free = free_.data();
  for (int k = 0; k < bands_.scratch_count(); ++k) {
    matrix_.push_back(a);
    matrix_.back().passed = rows_.scratch(k).passed;
  }
}

/// Coefficients as SheetMatrix wants them.
void SheetSystem::pack_bending(const GridStencil& bending) {
  const int width = kernels_.width;
  for (const GridStencil::Row& kind : bending.kind) {
    bending_.emplace_back(1, SheetMatrix::kBending * rows_.shape().stride);
    float* to = bending_.back().data();
    for (size_t k = 0; k < kind.size(); ++k) {
      for (size_t col = 0; col < kind[k].size(); ++col) {
        const size_t lane = col % static_cast<size_t>(width);
        to[(col - lane) * kind.size() + k * static_cast<size_t>(width) + lane] = static_cast<float>(kind[k][col]);
      }
    }
  }
  for (int kind : bending.kind_of_row) bending_rows_.push_back(bending_[static_cast<size_t>(kind)].data());
}

void SheetSystem::set_step(double tau, double mass_rate, Jacobian kind) {
  for (SheetMatrix& a : matrix_) {
    a.damping = static_cast<float>(damping_time_ / tau);
    a.bending_factor = static_cast<float>(1.0 + bending_damping_ / tau);
    a.transverse = kind == Jacobian::kAxial ? 0.0f : 1.0f;
  }
  multigrid_.tune(mass_rate, 1.0 + bending_damping_ / tau);
}

void SheetSystem::linearise(Xyz<double> x, const SheetShape<double>& shape) {
  bands_.run([&](const RowBand& rows, int) { kernels_.narrow(shape, x, x_.data(), rows); });
  bands_.run([&](const RowBand& rows, int) { kernels_.linearise(rows_.shape(), x_.data(), matrix(0), rows); });
  if (bands_.apart()) {
    bands_.run([&](const RowBand& rows, int) { kernels_.find_blocks(rows_.shape(), matrix(0), rows); });
  }
  if (!couplings_.empty() || !extra_.empty()) patch_diagonal();
  multigrid_.refresh(rows_.shape(), matrix(0), extra_);
}

/// Diagonal blocks of nodes that couplings name.
void SheetSystem::patch_diagonal() {
  patch_of_.resize(static_cast<size_t>(rows_.node_count()), -1);
  for (const SheetMultigrid::Extra& e : extra_) patch_of_[static_cast<size_t>(e.node)] = -1;
  extra_.clear();
  blocks_.clear();
  for (const SheetCoupling& c : couplings_) {
    double common = 0.0;
    for (int k = 0; k < c.count; ++k) common += c.weight[static_cast<size_t>(k)];
    for (int k = 0; k < c.count; ++k) {
      const int node = rows_.node(c.place[static_cast<size_t>(k)]);
      int& patch = patch_of_[static_cast<size_t>(node)];
      if (patch < 0) {
        patch = static_cast<int>(extra_.size());
        extra_.push_back({node, {}});
        blocks_.push_back(Mat3::Zero());
      }
      const double w = c.weight[static_cast<size_t>(k)];
      blocks_[static_cast<size_t>(patch)] += w * w * c.matrix;
      const auto together = six_of(w * common * c.matrix);
      for (size_t e = 0; e < together.size(); ++e) extra_[static_cast<size_t>(patch)].block[e] += together[e];
    }
  }
  for (size_t k = 0; k < extra_.size(); ++k) {
    const std::ptrdiff_t at = rows_.place(extra_[k].node);
    if (free_.data()[at] == 0.0f) continue;
    Mat3 inverse;
    const auto entry = [&](size_t e) { return static_cast<double>(inverse_[e].data()[at]); };
    inverse << entry(0), entry(1), entry(2), entry(1), entry(3), entry(4), entry(2), entry(4), entry(5);
    // (D + E)^-1 = (1 + D^-1 E)^-1 D^-1.
    const Mat3 whole = (Mat3::Identity() + inverse * blocks_[k]).inverse() * inverse;
    const auto both = six_of(0.5 * (whole + whole.transpose()));
    for (size_t e = 0; e < both.size(); ++e) inverse_[e].data()[at] = both[e];
  }
}

/// y += sign W^T H W p; work += p^T W^T H W p.
void SheetSystem::add_couplings(Xyz<float> p, float sign, Xyz<float> y, double* work) const {
  for (const SheetCoupling& c : couplings_) {
    Vec3 moved = Vec3::Zero();
    for (int k = 0; k < c.count; ++k) {
      const std::ptrdiff_t at = c.place[static_cast<size_t>(k)];
      moved += c.weight[static_cast<size_t>(k)] * Vec3(p.x[at], p.y[at], p.z[at]);
    }
    const Vec3 force = c.matrix * moved;
    if (work != nullptr) *work += moved.dot(force);
    for (int k = 0; k < c.count; ++k) {
      const std::ptrdiff_t at = c.place[static_cast<size_t>(k)];
      const Vec3 share = static_cast<double>(sign) * c.weight[static_cast<size_t>(k)] * force;
      y.x[at] += static_cast<float>(share[0]);
      y.y[at] += static_cast<float>(share[1]);
      y.z[at] += static_cast<float>(share[2]);
    }
  }
}

double SheetSystem::multiply(Xyz<float> z, float beta, Xyz<float> p, Xyz<float> y) {
  const SheetShape<float>& shape = rows_.shape();
  if (bands_.apart()) bands_.run([&](const RowBand& rows, int) { kernels_.turn(shape, z, beta, p, rows); });
  double work = bands_.sum(
      [&](const RowBand& rows, int scratch) { return kernels_.multiply(shape, matrix(scratch), z, beta, p, y, rows); });
  if (!couplings_.empty()) add_couplings(p, 1.0f, y, &work);
  return work;
}

/// y = r - A z.
void SheetSystem::find_residue(Xyz<float> z, Xyz<float> r, Xyz<float> y) {
  bands_.run(
      [&](const RowBand& rows, int scratch) { kernels_.residue(rows_.shape(), matrix(scratch), z, r, y, rows); });
  if (!couplings_.empty()) add_couplings(z, -1.0f, y, nullptr);
}

/// z_ = the preconditioner times r; returns r . z_. Uses y_.
double SheetSystem::precondition(Xyz<float> r) {
  const SheetShape<float>& shape = rows_.shape();
  const Xyz<float> y = y_.data(), z = z_.data();
  if (bands_.apart()) {
    bands_.run([&](const RowBand& rows, int) { kernels_.relax_first(shape, matrix(0), kSweep, r, z, rows); });
  }
  bands_.run(
      [&](const RowBand& rows, int scratch) { kernels_.relax_residue(shape, matrix(scratch), kSweep, r, z, y, rows); });
  if (!couplings_.empty()) add_couplings(z, -1.0f, y, nullptr);
  multigrid_.correct(y, z);
  double work;
  if (couplings_.empty()) {
    work = bands_.sum([&](const RowBand& rows, int scratch) {
      return kernels_.residue_relax(shape, matrix(scratch), kSweep, z, r, y, rows);
    });
  } else {
    find_residue(z, r, y);
    work =
        bands_.sum([&](const RowBand& rows, int) { return kernels_.relax(shape, matrix(0), kSweep, z, r, y, rows); });
  }
  std::swap(z_, y_);
  return work;
}

double SheetSystem::solve(const LinearTolerance& tolerance, double start, double free_count, LinearReport* report) {
  const SheetShape<float>& shape = rows_.shape();
  const Xyz<float> r = r_.data(), p = p_.data(), x = step_.data();
  step_.clear();
  const double enough = std::max(tolerance.absolute, tolerance.relative * start);
  const double squares = enough * enough * free_count;
  double slope = 0.0, before = 0.0;
  *report = LinearReport();
  report->solved = false;
  while (report->iterations < tolerance.iterations && !report->solved) {
    const double rz = precondition(r);
    const float beta = before > 0.0 ? static_cast<float>(rz / before) : 0.0f;
    const Xyz<float> y = y_.data();
    const double curvature = multiply(z_.data(), beta, p, y);
    if (!(curvature > 0.0) || !(rz > 0.0)) break;  // nothing left in single precision
    const double alpha = rz / curvature;
    slope += alpha * rz;
    before = rz;
    const double left = bands_.sum([&](const RowBand& rows, int) {
      return kernels_.descend(shape, static_cast<float>(alpha), p, y, weight_.data(), x, r, rows);
    });
    ++report->iterations;
    report->solved = left <= squares;
  }
  return slope;
}

}  // namespace deformable_sim
