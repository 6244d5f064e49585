// Every force term goes through the derivative harness; a term that is missing here is found by name.
#include <gtest/gtest.h>

#include <fstream>
#include <functional>
#include <map>
#include <random>
#include <regex>
#include <sstream>

#include "deformable_sim/core/energy/terms.h"
#include "support/derivative_harness.h"

namespace deformable_sim::test {
namespace {

constexpr int kNodes = 5;

struct Case {
  bool conservative;
  std::function<std::unique_ptr<Energy>()> make;
};

Air gusty_air() {
  Air air;
  air.drag_coefficient = 1.3;
  air.wind = Vec3(2.0, -1.0, 0.5);
  air.gust_amplitude = 0.4;
  return air;
}

std::unique_ptr<Energy> springs(double damping) {
  return make_springs("springs",
                      {{0, 1, 1.0, 300.0, damping},
                       {1, 2, 0.8, 50.0, damping},
                       {0, 2, 1.3, 7.0, damping},
                       {3, 1, 1.1, 120.0, damping},
                       {4, 3, 0.9, 90.0, damping}},
                      0);
}

/// By the name of the constructor or class in terms.h.
const std::multimap<std::string, Case>& cases() {
  static const std::multimap<std::string, Case> all = {
      {"make_springs", {true, [] { return springs(0.0); }}},
      {"make_springs", {true, [] { return springs(2.5); }}},
      {"make_line_bending", {true, [] { return make_line_bending(make_line(4.0, 4), 30.0, 0.0, 0); }}},
      {"make_line_bending", {true, [] { return make_line_bending(make_ring(1.0, 5), 30.0, 0.2, 0); }}},
      {"make_gravity",
       {true, [] { return make_gravity(Eigen::VectorXd::LinSpaced(kNodes, 0.1, 2.0), Vec3(1, 2, -9.81)); }}},
      {"make_mass_damping",
       {false, [] { return make_mass_damping(Eigen::VectorXd::LinSpaced(kNodes, 0.1, 2.0), 0.7); }}},
      {"make_sheet_drag",
       {false,
        [] {
          return make_sheet_drag({{0, 1, 2}, {1, 2, 3}, {4, 3, 0}}, gusty_air());
        }}},
      {"make_pressure",
       {true,
        [] {
          return make_pressure({{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}, 300.0, 0.4, 1);
        }}},
      {"make_line_drag",
       {false,
        [] {
          return make_line_drag({{0, 1}, {1, 2}, {4, 2}}, 0.02, gusty_air());
        }}},
      {"TargetSprings",
       {true,
        [] {
          auto term = std::make_unique<TargetSprings>(std::vector<int>{1, 3}, 40.0);
          term->set_targets((Nodes(3, 2) << 1, 2, 3, 4, 5, 6).finished());
          return term;
        }}},
  };
  return all;
}

/// Points about a metre apart; `scale` < 1 compresses springs, > 1 stretches them.
State random_state(unsigned seed, double scale) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal;
  State s;
  s.time = 0.31;
  s.x = Nodes::NullaryExpr(3, kNodes, [&] { return scale * normal(generator); });
  s.v = Nodes::NullaryExpr(3, kNodes, [&] { return normal(generator); });
  return s;
}

TEST(EveryTerm, HasTheDerivativesItDelivers) {
  // A = -(dx df/dx + dv df/dv) against central differences, stretched, about at rest, compressed, at random rotations.
  for (const auto& [name, c] : cases()) {
    for (unsigned seed = 0; seed < 4; ++seed) {
      for (const double scale : {0.3, 0.8, 2.0}) {
        SCOPED_TRACE(name + ", seed " + std::to_string(seed) + ", scale " + std::to_string(scale));
        check_derivatives(c.make().get(), random_state(seed, scale), c.conservative);
      }
    }
  }
}

TEST(EveryTerm, IsInTheListOfThisTest) {
  std::ifstream file(std::string(DEFORMABLE_SIM_SOURCE_DIR) + "/include/deformable_sim/core/energy/terms.h");
  std::stringstream text;
  text << file.rdbuf();
  const std::string header = text.str();
  const std::regex declaration(R"(unique_ptr<Energy>\s+(make_\w+)\(|class\s+(\w+)\s*:\s*public\s+Energy)");
  int found = 0;
  for (std::sregex_iterator it(header.begin(), header.end(), declaration), end; it != end; ++it, ++found) {
    const std::string name = (*it)[1].matched ? (*it)[1].str() : (*it)[2].str();
    EXPECT_GT(cases().count(name), 0u) << name << " has no derivative test";
  }
  EXPECT_GE(found, 6);
}

}  // namespace
}  // namespace deformable_sim::test
