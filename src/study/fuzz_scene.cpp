#include "fuzz_scene.h"

#include <algorithm>

#include "fuzz_parts.h"

namespace deformable_sim::fuzz {
namespace {

constexpr int kMostNodes = 500, kFewNodes = 120;

/// None, upwards, or up to a hundred m/s^2 anywhere.
std::array<double, 3> gravity(Drawing* d) {
  const int what = d->random.whole(0, 2);
  if (what == 0) return {0.0, 0.0, 0.0};
  if (what == 1) return {0.0, 0.0, 9.81};
  std::array<double, 3> g = d->turn();
  for (double& value : g) value *= 33.0;
  return g;
}

}  // namespace

std::array<double, 3> Drawing::place(double reach) {
  std::array<double, 3> p{};
  for (double& value : p) value = size * random.uniform(-reach, reach);
  p[2] += 0.5 * size;
  return p;
}

std::array<double, 3> Drawing::turn() {
  std::array<double, 3> rpy{};
  for (double& angle : rpy) angle = random.uniform(-3.0, 3.0);
  return rpy;
}

Tree Drawing::pose(const std::array<double, 3>& position, double turned) {
  Tree tree;
  tree["position"] = Tree(position);
  if (random.chance(turned)) tree["rpy"] = Tree(turn());
  return tree;
}

void draw_common(Drawing* d, DrawnBody body, Tree* map) {
  Random& r = d->random;
  const double level = static_cast<double>(d->bodies.size());
  const double aside = 0.3 * d->size;
  body.center = {r.uniform(-aside, aside), r.uniform(-aside, aside), d->size * (0.6 + 1.1 * level)};
  (*map)["pose"] = d->pose(body.center, 0.4);
  if (r.chance(0.3)) (*map)["friction"] = r.chance(0.3) ? 0.0 : r.decades(0.01, 10.0);
  if (r.chance(0.3)) (*map)["contact_radius"] = std::max(1e-4, d->size * r.decades(1e-3, 0.03));
  if (r.chance(0.35)) (*map)["touches"] = r.pick({"others", "all"});
  if (body.kind != "rope" && r.chance(0.3)) (*map)["contact_points"] = r.pick({"nodes", "faces", "anywhere"});
  if (r.chance(0.4)) {
    Tree pins = Tree::list();
    const size_t count = r.chance(0.5) ? 1 : body.features.size();
    for (size_t k = 0; k < count; ++k) {
      pins.push(body.features[k]);
      d->grasps.push_back("pin_" + body.name + "_" + body.features[k]);
    }
    (*map)["pins"] = pins;
    body.features.erase(body.features.begin(), body.features.begin() + static_cast<long>(count));
  }
  d->bodies.push_back(body);
  Tree entry;
  entry[body.kind] = *map;
  d->result.scene["bodies"].push(entry);
}

Case make_case(std::uint64_t seed) {
  Drawing d(seed);
  Random& r = d.random;
  d.result.scene["title"] = "Drawn by seed " + std::to_string(seed);
  if (r.chance(0.2)) d.result.scene["gravity"] = Tree(gravity(&d));
  d.size = r.chance(0.15) ? r.decades(0.03, 5.0) : r.uniform(0.2, 0.6);
  if (r.chance(0.15)) d.motion_ends = 1.0;
  draw_air(&d);
  d.result.scene["bodies"] = Tree::list();
  const int count = r.chance(0.6) ? 1 : r.whole(2, 3);
  for (int k = 0; k < count; ++k) {
    const int most = r.whole(12, (r.chance(0.1) ? kMostNodes : kFewNodes) / count);
    const std::string kind = r.pick({"cloth", "cloth", "rope", "soft"});
    if (kind == "cloth") draw_cloth(&d, most);
    if (kind == "rope") draw_rope(&d, most);
    if (kind == "soft") draw_soft(&d, most);
  }
  draw_colliders(&d);
  draw_grasps(&d);
  draw_script(&d);
  draw_commands(&d);
  draw_step(&d);
  return d.result;
}

std::string text_of(const Case& c) {
  std::string text = yaml_of(c.scene);
  for (const std::string& line : c.commands) text += line + "\n";
  return text;
}

}  // namespace deformable_sim::fuzz
