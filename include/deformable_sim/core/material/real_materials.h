// Real materials as tables give them: what a person can look up or measure. Independent of how a body is modelled.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace deformable_sim {

/// What every entry of the tables says about itself.
struct MaterialOrigin {
  std::string name;                    // lower case letters, digits and underscores
  std::string title;                   // in words
  std::string source;                  // where the numbers come from
  std::vector<std::string> estimated;  // keys whose value is estimated, not measured
};

/// An isotropic solid.
struct SolidData {
  MaterialOrigin origin;
  double youngs_modulus = 0.0;             // E, Pa
  double youngs_modulus_low = 0.0;         // Pa, the range over grades, ...
  double youngs_modulus_high = 0.0;        // ... directions and batches
  double poissons_ratio = 0.0;             // -1 < nu < 1/2
  double density = 0.0;                    // kg/m^3
  double elastic_limit = 0.0;              // strain at which it yields, breaks, or its linear range ends
  std::string limit_kind;                  // yield | fracture | linear_range
  std::string law = "stable_neo_hookean";  // the stress-strain law that suits it

  double shear_modulus() const { return youngs_modulus / (2.0 * (1.0 + poissons_ratio)); }
  double bulk_modulus() const { return youngs_modulus / (3.0 * (1.0 - 2.0 * poissons_ratio)); }
};

/// A fabric, film or paper. In its plane, warp along 1 and weft along 2, the stresses (N/m) of small strains are
///
///   s11 = warp e11 + poisson e22,   s22 = poisson e11 + weft e22,   s12 = shear gamma12
///
/// and bending to the curvature kappa takes the moment B kappa per length. Membrane and bending are independent: E h^3
/// / 12 of the membrane's E is about ten times below what is measured on woven cloth.
struct FabricData {
  MaterialOrigin origin;
  double areal_density = 0.0;               // kg/m^2
  std::optional<double> thickness;          // m, where known
  double warp = 0.0, weft = 0.0;            // N/m
  double poisson = 0.0;                     // N/m, as measured; may be negative (knits)
  double shear = 0.0;                       // N/m
  double bend_warp = 0.0, bend_weft = 0.0;  // N m
  std::optional<double> bend_diagonal;      // N m, of a strip cut at 45 degrees, where measured
  double limit = 0.0;                       // strain up to which the constants hold

  /// `poisson`, brought to within 0.9 sqrt(warp weft) and 0.9 weft: a fit to noisy tests of a soft knit may lie beyond,
  /// and the sheet would gain energy by being pulled.
  double stable_poisson() const;
  /// What a strip pulled along warp or weft shows: force per width over strain (N/m).
  double traction_warp() const { return warp - stable_poisson() * stable_poisson() / weft; }
  double traction_weft() const { return weft - stable_poisson() * stable_poisson() / warp; }
  /// Contraction along the weft per extension of a strip pulled along the warp; magnitude at most 0.9.
  double poissons_ratio() const { return stable_poisson() / weft; }
  /// Traction stiffness of a strip cut at 45 degrees: 4 / E45 = S11 + S22 + 2 S12 + 1 / shear, S the inverse of the
  /// plane's 2 x 2.
  double traction_bias() const;
  /// Twisting moment per 2 kappa_12 (N m) that makes a strip cut at 45 degrees bend as measured, Poisson's ratio 0:
  /// 4 / B45 = 1 / B_warp + 1 / B_weft + 1 / twist. None where B45 is unknown or larger than that allows.
  std::optional<double> bend_twist() const;
  /// (B / (rho g))^(1/3), m: half the overhang at which a strip's chord reaches 41.5 degrees.
  double bending_length() const;
};

/// A yarn, rope, cable or wire.
struct RopeData {
  MaterialOrigin origin;
  double linear_density = 0.0;  // kg/m
  double diameter = 0.0;        // m, outer
  double axial = 0.0;           // EA, N
  double bending = 0.0;         // EI, N m^2
  double twist = 0.0;           // GJ, N m^2
  double breaking_strain = 0.0;
  /// E / rho of the fibre (m^2/s^2; 1 N/tex = 1e6 m^2/s^2) and the share of it that the construction keeps.
  double specific_modulus = 0.0;
  double construction = 1.0;

  /// sqrt(EA / linear density), m/s: how fast a pull travels along it, whatever its diameter.
  double wave_speed() const;
};

}  // namespace deformable_sim
