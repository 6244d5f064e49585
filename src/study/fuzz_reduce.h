// A failing case cut down to a small one.
#pragma once

#include <functional>

#include "fuzz_scene.h"

namespace deformable_sim::fuzz {

/// Leaves out commands, bodies, colliders, events and keys one after another, the larger first, then halves whole
/// numbers and rounds others, as long as the case still fails; until nothing more can go, or after `most` trials
/// [Zeller, Hildebrandt 2002: one at a time, which suits trees as small as these].
Case reduce(const Case& failing, const std::function<bool(const Case&)>& fails, int most = 400);

}  // namespace deformable_sim::fuzz
