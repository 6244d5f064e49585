// The stress that is shown where a law has none.
#pragma once

namespace deformable_sim {

/// Pa; also N/m. neo_hookean and mooney_rivlin have no stress where a body is turned inside out: what is published and
/// drawn is this, beyond all that a body bears, and a number.
constexpr float kLargestStress = 1e20f;

/// `stress`, but for what is no number or larger than all.
inline float shown_stress(float stress) {
  return stress <= kLargestStress ? stress : kLargestStress;
}

}  // namespace deformable_sim
