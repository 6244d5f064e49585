// Tests of a sheet out of its plane: cantilever, twist, drape.
#pragma once

#include "bench.h"
#include "cloth_models.h"

namespace deformable_sim::study {

/// Bending rigidity (N m) by ASTM D1388: rho g L^3 / 8.004 at the overhang L whose chord reaches 41.5 degrees. The
/// strip is 25 mm wide, or a twenty-fifth of its overhang where it is cut on the bias (it twists as it bends, which the
/// clamp of a wide one hinders), `angle` between its length and the warp, `cells` elements along the overhang, the
/// clamp line in the middle of the clamped elements. Appends the shape to `curves` when that is not null.
Measurement bend_strip(const FabricData& fabric, const ClothModel& model, double angle, int cells,
                       std::vector<Curve>* curves);

/// Twisting rigidity (N m): a square pulled up at two opposite corners and down at the others bends to w = kappa x y.
Measurement twist_square(const FabricData& fabric, const ClothModel& model, int cells);

/// Cusick's drapemeter (ISO 9073-9): a circle of 300 mm clamped on a disc of 180 mm.
struct Drape {
  int nodes = 0;
  double coefficient = 0.0;  // percent of the ring that casts a shadow
  int folds = 0;             // nodes of the drape: the strongest harmonic of its outline
  bool settled = false;
  Curve outline;  // m
};
/// How a coarser mesh hangs: where the next one starts from, so that both fold alike.
struct DrapeShape {
  int rings = 0;
  Nodes displacement;  // m
};
Drape drape(const FabricData& fabric, const ClothModel& model, int rings, DrapeShape* shape);

}  // namespace deformable_sim::study
