// What a network of springs is as a material, and how far that is from what was asked for.
#pragma once

#include <string>

#include "deformable_sim/core/material/spring_network.h"

namespace deformable_sim {

using Mat6 = Eigen::Matrix<double, 6, 6>;

/// Elastic constants along the axes x, y (and z) of a network. Sheets: E h and G h, N/m; solids: E and G, Pa.
struct SpringModuli {
  Vec3 youngs_modulus = Vec3::Zero();  // pulled along x, y, z (sheets: z unused)
  double poissons_ratio = 0.0;         // pulled along x, of y
  double shear_modulus = 0.0;          // in the x-y plane
};

/// Born moduli C_abcd = sum k l^2 n_a n_b n_c n_d / A of a flat sheet in the x-y plane, N/m, in the order xx, yy, xy
/// with engineering shear: what the network answers with as long as every node follows the mean strain. Exact for grids
/// (their edges are corrected), an upper bound for irregular meshes. area: m^2.
Mat3 sheet_moduli(const Nodes& rest, const SpringNetwork& network, double area);

/// The same of a solid, Pa, in the order xx, yy, zz, yz, xz, xy. volume: m^3.
Mat6 solid_moduli(const Nodes& rest, const SpringNetwork& network, double volume);

/// Constants a testing machine finds: from the compliance, free sides. A direction without stiffness has modulus 0.
SpringModuli constants_of(const Mat3& moduli);
SpringModuli constants_of(const Mat6& moduli);

/// Central springs make C_abcd symmetric in all indices (Cauchy): of nu and G at most one can be had. One line that
/// says what was asked for and what the network is, empty when they agree within 1 %. `modulus` is E or E h.
std::string spring_gap(double modulus, double poissons_ratio, const SpringModuli& found);

}  // namespace deformable_sim
