// Air drag on sheets and lines as terms of the equations of motion.
#include <cmath>

#include "deformable_sim/core/element/line_drag.h"
#include "deformable_sim/core/element/sheet_drag.h"
#include "deformable_sim/core/energy/element_energy.h"
#include "deformable_sim/core/energy/terms.h"

namespace deformable_sim {

Vec3 Air::wind_at(double time) const {
  return wind * (1.0 + gust_amplitude * std::sin(2.0 * M_PI * gust_frequency * time));
}

std::unique_ptr<Energy> make_sheet_drag(const std::vector<std::array<int, 3>>& triangles, const Air& air) {
  std::vector<ElementEnergy<SheetDrag>::Element> elements;
  elements.reserve(triangles.size());
  for (const auto& triangle : triangles) elements.push_back({triangle, {}});
  return std::make_unique<ElementEnergy<SheetDrag>>("sheet drag", std::move(elements), air);
}

std::unique_ptr<Energy> make_line_drag(const std::vector<std::array<int, 2>>& segments, double diameter,
                                       const Air& air) {
  std::vector<ElementEnergy<LineDrag>::Element> elements;
  elements.reserve(segments.size());
  for (const auto& segment : segments) elements.push_back({segment, {}});
  return std::make_unique<ElementEnergy<LineDrag>>("line drag", std::move(elements),
                                                   LineDrag::Parameters{air, diameter});
}

}  // namespace deformable_sim
