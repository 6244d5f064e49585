// Every test of a fabric, with one model of it.
#include <cmath>

#include "bench.h"
#include "cloth_bending.h"
#include "cloth_plane.h"

namespace deformable_sim::study {
namespace {

const char kSpringsOneModulus[] =
    "springs have one stiffness for warp and weft: the mean of the two is used, and the weave's difference is lost";
const char kSpringsCauchy[] =
    "central springs: of Poisson's ratio and shear stiffness only one is free (C12 = C66), on other meshes than grids "
    "neither (nu = 1/3)";
const char kSpringsNoBending[] =
    "springs over two cells have no linear bending stiffness: a fold by phi stores k a^2 phi^4 / 32, so that what a "
    "cantilever shows depends on the mesh";

const char kBiasClamp[] =
    "a strip cut on the bias twists as it bends: its clamp and elements longer than the strip is wide hinder that";

constexpr double kDrapesAgree = 3.0;  // percent of the ring, between meshes

void add_plane_tests(const Bench& bench, const FabricData& f, const ClothModel& model, const std::vector<int>& sizes,
                     Report* report) {
  const auto traction = [&](Along along, bool ratio) {
    return [&f, &model, along, ratio](int n) {
      const Traction t = pull_strip(f, model, along, n);
      return Measurement{t.nodes, ratio ? t.ratio : t.stiffness, 0.0};
    };
  };
  auto& rows = report->rows;
  const double c12 = f.stable_poisson();
  rows.push_back(row_of(bench, "traction", "force/width/strain, warp", "N/m", f.traction_warp(), sizes,
                        traction(Along::kWarp, false)));
  rows.push_back(row_of(bench, "traction", "force/width/strain, weft", "N/m", f.traction_weft(), sizes,
                        traction(Along::kWeft, false)));
  rows.push_back(row_of(bench, "traction", "Poisson's ratio, pulled along warp", "", f.poissons_ratio(), sizes,
                        traction(Along::kWarp, true)));
  rows.push_back(row_of(bench, "shear", "shear stress / angle", "N/m", f.shear, sizes,
                        [&](int n) { return shear_square(f, model, n); }));
  rows.push_back(row_of(bench, "compression", "mean pressure / loss of area", "N/m",
                        0.25 * (f.warp + f.weft + 2.0 * c12), sizes,
                        [&](int n) { return compress_square(f, model, n); }));
  rows.push_back(row_of(bench, "bias extension", "stress / strain at 45 degrees", "N/m", f.traction_bias(), sizes,
                        [&](int n) { return pull_on_the_bias(f, model, n); }));
  if (!model.springs) return;
  for (Row& row : rows) {
    if (row.error() && std::abs(*row.error()) > 0.02) row.gap = "central springs cannot represent this fabric's value";
  }
}

void add_bending_tests(const Bench& bench, const FabricData& f, const ClothModel& model, const std::vector<int>& sizes,
                       Report* report) {
  auto& rows = report->rows;
  const auto bend = [&](const std::string& what, double put_in, double angle, bool draw) {
    rows.push_back(row_of(bench, "cantilever 41.5", what, "N m", put_in, sizes,
                          [&](int n) { return bend_strip(f, model, angle, n, draw ? &report->curves : nullptr); }));
    if (model.bend_springs) rows.back().gap = kSpringsNoBending;
  };
  bend("bending rigidity, warp", f.bend_warp, 0.0, true);
  if (model.springs) {
    rows.back().gap = model.bend_springs ? kSpringsNoBending : "";
  } else {
    bend("bending rigidity, weft", f.bend_weft, 0.5 * kPi, false);
    if (f.bend_twist()) {
      bend("bending rigidity, 45 degrees", *f.bend_diagonal, 0.25 * kPi, false);
      if (rows.back().error() && std::abs(*rows.back().error()) > 0.01) rows.back().gap = kBiasClamp;
    }
  }
  if (model.bend_springs) return;
  rows.push_back(row_of(bench, "torsion", "twisting moment / 2 twist", "N m",
                        f.bend_twist().value_or(0.5 * std::sqrt(f.bend_warp * f.bend_weft)), sizes,
                        [&](int n) { return twist_square(f, model, n); }));
}

void add_drape(const Bench& bench, const FabricData& f, const ClothModel& model, Report* report) {
  std::vector<Measurement> folds;
  bool settled = true;
  DrapeShape shape;
  report->rows.push_back(
      row_of(bench, "Cusick drape", "drape coefficient", "%", std::nullopt, {3, 6, 12}, [&](int rings) {
        const Drape found = drape(f, model, rings, &shape);
        folds.push_back({found.nodes, static_cast<double>(found.folds), 0.0});
        report->curves.push_back(found.outline);
        settled = settled && found.settled;
        return Measurement{found.nodes, found.coefficient, 0.0};
      }));
  Row& coefficient = report->rows.back();
  if (!settled) {
    coefficient.gap = "the statics did not settle at every size: the sheet is still sliding";
  } else if (std::abs(coefficient.measured[2].value - coefficient.measured[1].value) > kDrapesAgree) {
    coefficient.gap = "the two finest meshes differ by more than 3 points: no drape of this fabric yet";
  }
  Row row;
  row.test = "Cusick drape";
  row.quantity = "nodes (folds)";
  row.measured = folds;
  report->rows.push_back(row);
}

}  // namespace

Report study_cloth(const FabricData& fabric, const std::string& name, const Bench& bench) {
  const ClothModel model = cloth_model(name);
  Report report;
  report.material = fabric.origin.name;
  report.title = fabric.origin.title;
  report.kind = "fabric";
  report.model = name;
  report.source = fabric.origin.source;
  const bool full = bench.effort == Effort::kFull;
  add_plane_tests(bench, fabric, model, full ? std::vector<int>{2, 4, 8} : std::vector<int>{2, 4}, &report);
  add_bending_tests(bench, fabric, model, full ? std::vector<int>{8, 16, 32} : std::vector<int>{6, 12}, &report);
  if (full) add_drape(bench, fabric, model, &report);
  if (model.springs) report.gaps = {kSpringsOneModulus, kSpringsCauchy};
  if (model.bend_springs) report.gaps.push_back(kSpringsNoBending);
  if (fabric.stable_poisson() != fabric.poisson) {
    report.gaps.push_back("the tabulated poisson lies beyond what a stable sheet can have and was limited");
  }
  return report;
}

}  // namespace deformable_sim::study
