// How bodies are drawn.
#include "build_parts.h"
#include "deformable_sim/core/topology/sheet_cut.h"

namespace deformable_sim {
namespace {

/// Much lighter: two thirds of the way to white.
std::array<double, 3> lighter(const std::array<double, 4>& color) {
  std::array<double, 3> light{};
  for (size_t k = 0; k < 3; ++k) light[k] = (color[k] + 2.0) / 3.0;
  return light;
}

}  // namespace

void add_look(const BodySpec& spec, Body* body) {
  body->stripe = spec.look.stripe;
  if (spec.kind != BodyKind::kCloth) return;
  const double thickness = spec.look.thickness.value_or(spec.cloth_material.thickness);
  if (spec.look.checker == 0.0 && spec.look.seams == 0.0 && thickness == 0.0) return;
  auto look = std::make_shared<SheetLook>();
  look->thickness = thickness;
  look->checker_color = spec.look.checker_color.value_or(lighter(body->color));
  try {
    look->cut = cut_sheet(body->skin ? body->skin->surface() : *body->surface, {spec.look.checker, spec.look.seams});
  } catch (const InputError& error) {
    const std::string line = spec.look.where.line > 0 ? ":" + std::to_string(spec.look.where.line) : "";
    throw PlacedError(spec.look.where.file + line + ": " + spec.look.path + ": " + error.what(), error.code());
  }
  body->look = look;
}

}  // namespace deformable_sim
