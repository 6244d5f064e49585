// Trajectories computed by an independent program to 1e-11, and the errors a correct scheme makes against them.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>

#include "support/system.h"

namespace deformable_sim::test {
namespace {

std::vector<std::vector<std::string>> read_table(const std::string& name) {
  std::ifstream file(std::string(DEFORMABLE_SIM_SOURCE_DIR) + "/test/verify/data/" + name);
  EXPECT_TRUE(file.good()) << name;
  std::vector<std::vector<std::string>> rows;
  std::string line;
  std::getline(file, line);  // heading
  while (std::getline(file, line)) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    std::stringstream cells(line);
    rows.emplace_back();
    for (std::string cell; std::getline(cells, cell, ',');) rows.back().push_back(cell);
  }
  return rows;
}

/// Positions of all nodes at time t.
Nodes golden_positions(const std::string& name, double t) {
  Nodes x = Nodes::Zero(3, 10);
  int found = 0;
  for (const auto& row : read_table(name)) {
    if (std::abs(std::stod(row[0]) - t) > 1e-9) continue;
    x.col(std::stoi(row[1])) = Vec3(std::stod(row[2]), std::stod(row[3]), std::stod(row[4]));
    ++found;
  }
  EXPECT_EQ(found, 10);
  return x;
}

/// The chain of data/README.md after one second; not finite when the scheme diverges.
Nodes chain_after_one_second(const std::string& scheme, double dt, double damping) {
  Nodes x = Nodes::Zero(3, 10);
  std::vector<SpringLink> links;
  for (int i = 0; i < 10; ++i) {
    x(0, i) = 0.1 * i;
    if (i > 0) links.push_back({i - 1, i, 0.1, 1e3, damping});
  }
  System chain(x, Eigen::VectorXd::Constant(10, 0.01));
  chain.add(make_springs("springs", links, 0)).add_gravity().hold(0);
  const auto integrator = make_integrator(scheme, exact_settings(1e-7));
  const int steps = static_cast<int>(std::lround(1.0 / dt));
  for (int k = 0; k < steps; ++k) chain.step(*integrator, dt);
  return chain.state.x;
}

double rms(const Nodes& difference) {
  return std::sqrt(difference.squaredNorm() / static_cast<double>(difference.cols()));
}

TEST(GoldenChain, ShowsTheErrorThatEachSchemeMustMake) {
  // Within 2 % of the tabulated RMS error, wherever that is below 0.1 m (above, branches of a whip decide).
  const Nodes reference = golden_positions("golden_chain10_soft_damped.csv", 1.0);
  int compared = 0;
  for (const auto& row : read_table("expected_errors.csv")) {
    const std::string scheme = row[1];
    const double dt = std::stod(row[2]), expected = std::stod(row[3]);
    const Nodes end = chain_after_one_second(scheme, dt, 0.05);
    SCOPED_TRACE(scheme + ", dt " + row[2]);
    if (row[4] == "diverged") {
      EXPECT_FALSE(end.allFinite() && end.norm() < 1e3);
      continue;
    }
    if (expected >= 0.1 || expected < 1e-10) continue;  // the table itself is good to 2e-11 m
    const double error = rms(end - reference);
    EXPECT_NEAR(error, expected, 0.02 * expected);
    ++compared;
  }
  EXPECT_GE(compared, 10);
}

TEST(GoldenChain, IsReachedWithoutDampingToo) {
  // Fourth order: at dt = 1e-4 s the error is a few 1e-9 m of a whip of 0.9 m.
  const Nodes reference = golden_positions("golden_chain10_soft.csv", 1.0);
  EXPECT_LT(rms(chain_after_one_second("rk4", 1e-4, 0.0) - reference), 1e-7);
  EXPECT_LT(rms(chain_after_one_second("symplectic_euler", 5e-5, 0.0) - reference), 2e-3);
}

}  // namespace
}  // namespace deformable_sim::test
