// Error against run time: what errors mean, what is worth choosing, and the program from end to end.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <yaml-cpp/yaml.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>

#include "study/work_precision_case.h"
#include "study/work_precision_errors.h"
#include "study/work_precision_front.h"
#include "study/work_precision_parts.h"
#include "study/work_precision_plan.h"
#include "study/work_precision_reference.h"
#include "study/work_precision_store.h"
#include "support/slope.h"

namespace deformable_sim::work_precision {
namespace {

namespace fs = std::filesystem;

/// Two nodes 2 m apart along x, joined by an edge.
std::shared_ptr<const Model> two_nodes() {
  auto model = std::make_shared<Model>();
  Body body;
  body.name = "pair";
  body.kind = BodyKind::kRope;
  body.node_count = 2;
  body.strain_edges = {{{0, 1}, 2.0}};
  model->bodies = {body};
  model->mass = Eigen::VectorXd::Ones(2);
  model->initial.x = model->initial.v = Nodes::Zero(3, 2);
  model->initial.x(0, 1) = 2.0;
  return model;
}

/// The two nodes with the second one moved, four times the same.
Trajectory moved(const Vec3& by, double kinetic = 0.0, const Vec3& pull = Vec3::Zero()) {
  Sample s;
  s.x = two_nodes()->initial.x;
  s.x.col(1) += by;
  s.kinetic = kinetic;
  s.pull.setZero(6, 1);
  s.pull.col(0).head<3>() = pull;
  return Trajectory(kQuarters, s);
}

Yardstick yardstick() {
  return {two_nodes(), two_nodes()->initial};
}

TEST(WorkPrecisionErrors, PositionIsTheRmsOverNodesRelativeToTheBodysSize) {
  // One of two nodes is 3 cm away, the body is 2 m long: 0.03 / sqrt(2) / 2.
  const Errors e = yardstick().errors(moved(Vec3(0, 0.03, 0)), moved(Vec3::Zero()));
  EXPECT_NEAR(e.position, 0.03 / std::sqrt(2.0) / 2.0, 1e-15);
  EXPECT_NEAR(e.position_end, e.position, 1e-15);
}

TEST(WorkPrecisionErrors, PositionIsTheLargestOfTheInstantsAndTheEndIsTheLast) {
  Trajectory run = moved(Vec3::Zero());
  run[1].x(1, 0) += 0.2;
  run[3].x(1, 0) += 0.1;
  const Errors e = yardstick().errors(run, moved(Vec3::Zero()));
  EXPECT_NEAR(e.position, 0.2 / std::sqrt(2.0) / 2.0, 1e-15);
  EXPECT_NEAR(e.position_end, 0.1 / std::sqrt(2.0) / 2.0, 1e-15);
}

TEST(WorkPrecisionErrors, StrainAndLengthAreThoseOfTheEdge) {
  // 2.02 m against 2 m of an edge of 2 m: 1 % of strain, 1 % of length.
  const Errors e = yardstick().errors(moved(Vec3(0.02, 0, 0)), moved(Vec3::Zero()));
  EXPECT_NEAR(e.strain, 0.01, 1e-15);
  EXPECT_NEAR(e.measure, 0.01, 1e-15);
}

TEST(WorkPrecisionErrors, EnergyIsRelativeToWhatMovesInTheReference) {
  EXPECT_NEAR(yardstick().errors(moved(Vec3::Zero(), 5.5), moved(Vec3::Zero(), 5.0)).energy, 0.1, 1e-15);
}

TEST(WorkPrecisionErrors, GraspForceIsRelativeToTheLargestOfTheReference) {
  const Trajectory reference = moved(Vec3::Zero(), 0.0, Vec3(0, 0, -2.0));
  EXPECT_NEAR(yardstick().errors(moved(Vec3::Zero(), 0.0, Vec3(0, 0.5, -2.0)), reference).grasp, 0.25, 1e-15);
}

TEST(WorkPrecisionErrors, KnowNothingOfARunThatEndedBeforeTheFirstInstant) {
  const Errors e = yardstick().errors({}, moved(Vec3::Zero()));
  EXPECT_TRUE(std::isnan(e.position) && std::isnan(e.strain) && std::isnan(e.energy));
  Trajectory broken = moved(Vec3::Zero());
  broken[2].x(0, 0) = kNone;
  EXPECT_TRUE(std::isnan(yardstick().errors(broken, moved(Vec3::Zero())).position)) << "a NaN is not lost";
}

TEST(WorkPrecisionReference, ExtrapolationRemovesThePowerOfTheStep) {
  // x(h) = x0 + C h^p: from h and h/2 the limit is exact.
  for (const int order : {1, 2, 4}) {
    const Vec3 c(0.1, -0.2, 0.3);
    const Trajectory found = extrapolated(moved(c * std::exp2(-order)), moved(c), order);
    EXPECT_LT(yardstick().position(found, moved(Vec3::Zero())), 1e-15) << order;
  }
}

TEST(WorkPrecisionReference, ResolvesThreeTimesWhatItHasReached) {
  Reference r;
  EXPECT_TRUE(std::isinf(r.resolution())) << "nothing is known";
  r.reached = 1e-6;
  r.check_reached = 1e-5;
  r.check_difference = 2e-5;
  EXPECT_DOUBLE_EQ(r.resolution(), 3e-6) << "the check's own error explains the difference";
  r.check_difference = 1e-3;
  EXPECT_DOUBLE_EQ(r.resolution(), 1e-3) << "two that disagree resolve no more than that";
}

Row row(double cost, double error, int steps = 1, const std::string& integrator = "bdf2") {
  Row r;
  r.configuration.integrator = integrator;
  r.configuration.linear_solver = "direct";
  r.configuration.newton_iterations = 1;
  r.configuration.steps = steps;
  r.dt = 0.25 / steps;
  r.cost.cpu = r.cpu_seconds = cost;
  r.errors.position = error;
  return r;
}

TEST(WorkPrecisionFront, HoldsOnlyRunsThatNoCheaperOneBeats) {
  std::vector<Row> rows = {row(3, 0.01), row(1, 0.1), row(2, 0.2), row(4, 0.01), row(5, 0.001), row(0.1, 0.0001)};
  rows[5].status = Status::kDiverged;
  EXPECT_EQ(pareto_front(rows, 0.0), (std::vector<int>{1, 0, 4}));
  EXPECT_EQ(pareto_front(rows, 0.02), (std::vector<int>{1, 0})) << "below the resolution all are alike";
}

TEST(WorkPrecisionFront, PicksTheCheapestForEachErrorAndSaysWhyThereIsNone) {
  const std::vector<Pick> found = picks({row(1, 0.015), row(2, 0.009), row(9, 0.0029)}, 0.0005);
  ASSERT_EQ(found.size(), 5u);
  EXPECT_EQ(found[0].row, 0);
  EXPECT_EQ(found[1].row, 1);
  EXPECT_EQ(found[2].row, 2);
  EXPECT_EQ(found[3].row, -1);
  EXPECT_EQ(found[3].why, "no run reached it");
  EXPECT_EQ(found[4].why, "the reference does not resolve it");
}

TEST(WorkPrecisionPlan, GoesOnWhileAFinerStepPays) {
  const std::vector<Row> family = {row(1, 0.1), row(2, 0.03), row(4, 0.008)};
  EXPECT_EQ(reason_to_stop(family, family, 1e-8), "");
  EXPECT_EQ(reason_to_stop(family, family, 0.01), "below what the reference can resolve");
}

TEST(WorkPrecisionPlan, GivesUpWhatIsFarBehindTwiceStuckOrDiverging) {
  const std::vector<Row> family = {row(10, 0.1), row(20, 0.03)};
  std::vector<Row> all = family;
  all.push_back(row(20.0 / kFar * 1.01, 0.02));
  EXPECT_EQ(reason_to_stop(family, all, 1e-8), "") << "only the first was not beaten by far";
  all.push_back(row(10.0 / kFar * 0.99, 0.02));
  EXPECT_EQ(reason_to_stop(family, all, 1e-8), "far behind others");
  const std::vector<Row> stuck = {row(1, 0.1), row(2, 0.099), row(4, 0.098)};
  EXPECT_EQ(reason_to_stop(stuck, stuck, 1e-8), "a smaller step does not help");
  std::vector<Row> diverging(4, row(1, kNone));
  for (Row& r : diverging) r.status = Status::kDiverged;
  EXPECT_EQ(reason_to_stop(diverging, diverging, 1e-8), "diverges");
  diverging.pop_back();
  EXPECT_EQ(reason_to_stop(diverging, diverging, 1e-8), "");
}

TEST(WorkPrecisionPlan, ExpectsTwiceTheCostOfHalfTheStep) {
  const std::vector<Row> rows = {row(3, 0.1, 15)};
  EXPECT_DOUBLE_EQ(expected_cpu(row(0, 0, 30).configuration, rows), 6.0);
  Configuration dearer = row(0, 0, 15).configuration;
  dearer.newton_iterations = 4;
  EXPECT_DOUBLE_EQ(expected_cpu(dearer, rows), 3.0) << "at least what one iteration took";
  EXPECT_DOUBLE_EQ(expected_cpu(row(0, 0, 15, "rk4").configuration, {}), 0.0);
}

TEST(WorkPrecisionParts, FindsTheNodesThatTwoMeshesShare) {
  Nodes coarse = Nodes::Zero(3, 2), fine = Nodes::Zero(3, 3);
  coarse(0, 1) = 1.0;
  fine.row(0) << 1.0, 0.5, 1e-12;
  EXPECT_EQ(common_nodes(coarse, fine, 2), (std::vector<int>{2, 0}));
  coarse(1, 1) = 0.01;
  EXPECT_TRUE(common_nodes(coarse, fine, 2).empty());
}

class Folder {
 public:
  explicit Folder(const std::string& name)
      : path_(fs::temp_directory_path() / ("work_precision_" + name + "_" + std::to_string(::getpid()))) {
    fs::create_directories(path_);
  }
  ~Folder() { fs::remove_all(path_); }
  std::string operator/(const std::string& file) const { return (path_ / file).string(); }

 private:
  fs::path path_;
};

TEST(WorkPrecisionLog, GivesRowsBackExactlyAndOnlyToTheSameSceneAndProgram) {
  const Folder folder("log");
  const std::string path = folder / "runs.csv";
  Row first = row(1.0 / 3.0, 0.1 + 1e-17, 7);
  first.note = "a, b\nc";
  {
    RunLog log(path, "scene", "program", RunLog::Start::kAnew);
    log.append(first);
    log.append(row(2, kNone, 8));
  }
  std::ofstream(path, std::ios::app) << "scene,program,bdf2,direct";  // cut short
  const RunLog log(path, "scene", "program", RunLog::Start::kResume);
  EXPECT_EQ(log.known(), 2u);
  const Row* found = log.find(first.configuration);
  ASSERT_NE(found, nullptr);
  EXPECT_EQ(found->cost.cpu, first.cost.cpu);
  EXPECT_EQ(found->note, "a; b;c");
  EXPECT_EQ(log.find(row(0, 0, 9).configuration), nullptr);
  EXPECT_EQ(RunLog(path, "scene", "other", RunLog::Start::kResume).known(), 0u);
  EXPECT_EQ(RunLog(path, "other", "program", RunLog::Start::kResume).known(), 0u);
  EXPECT_EQ(RunLog(path, "scene", "program", RunLog::Start::kAnew).known(), 0u);
}

TEST(WorkPrecisionLog, KeepsAReferenceExactly) {
  const Folder folder("reference");
  Reference r;
  r.trajectory = moved(Vec3(0.1, 0.2, 1.0 / 3.0), 0.7, Vec3(1, 2, 3));
  r.method = "rk4, twice";
  r.check_method = "tr_bdf2";
  r.reached = 1e-9;
  r.halvings = {{{0.1, 0.2}}};
  write_reference(folder / "r", "scene", "program", r);
  Reference found;
  EXPECT_FALSE(read_reference(folder / "r", "scene", "other", &found));
  ASSERT_TRUE(read_reference(folder / "r", "scene", "program", &found));
  EXPECT_EQ(found.trajectory[3].x, r.trajectory[3].x);
  EXPECT_EQ(found.trajectory[3].pull, r.trajectory[3].pull);
  EXPECT_EQ(found.method, r.method);
  EXPECT_EQ(found.reached, r.reached);
  EXPECT_TRUE(std::isnan(found.check_difference));
  EXPECT_EQ(found.halvings, r.halvings);
}

struct Outcome {
  int code = -1;
  std::string out;
};

Outcome study(const std::string& arguments) {
  Outcome outcome;
  FILE* pipe = popen((std::string(STUDY_PATH) + " work_precision " + arguments + " 2>&1").c_str(), "r");
  if (!pipe) return outcome;
  std::array<char, 4096> buffer{};
  while (size_t n = fread(buffer.data(), 1, buffer.size(), pipe)) outcome.out.append(buffer.data(), n);
  const int status = pclose(pipe);
  outcome.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return outcome;
}

const char kSwing[] =
    "bodies:\n"
    "  - rope:\n"
    "      name: rope\n"
    "      segments: 6\n"
    "      material: {linear_density: 0.05, axial_stiffness: 20, bend_stiffness: 0, damping: 0}\n"
    "      pins: [end_0]\n";

/// JSON is YAML.
class SmallStudy : public testing::Test {
 protected:
  SmallStudy() : folder_("swing") { std::ofstream(folder_ / "swing.yaml") << kSwing; }
  Outcome go(const std::string& more) {
    const std::string line = (folder_ / "swing.yaml") + " --quick --seconds 0.3 --budget 6 --out " + (folder_ / "out");
    return study(line + " " + more);
  }
  YAML::Node result() { return YAML::LoadFile(folder_ / "out/swing.json"); }
  std::string runs() { return content_of(folder_ / "out/swing.runs.csv"); }
  Folder folder_;
};

TEST_F(SmallStudy, FindsTheOrderOfEverySchemeAndTheReferenceThatProvesIt) {
  // error = C dt^p of the scheme, Newton converged; the ropes's motion is smooth. p to 15 % over three halvings.
  const Outcome outcome = go("--quiet");
  ASSERT_EQ(outcome.code, 0) << outcome.out;
  const YAML::Node found = result();
  EXPECT_LT(found["reference"]["reached"].as<double>(), kReferenceGoal);
  EXPECT_LT(found["reference"]["check_difference"].as<double>(), 1e-6);
  std::map<std::string, std::array<std::vector<double>, 2>> errors;
  for (const YAML::Node& run : found["runs"]) {
    if (run["family"].as<std::string>().find(", banded, Newton converged") == std::string::npos) continue;
    auto& [step, error] = errors[run["integrator"].as<std::string>()];
    step.push_back(run["dt_s"].as<double>());
    error.push_back(run["position_error"].as<double>());
    EXPECT_TRUE(run["settled"].as<bool>());
  }
  const std::map<std::string, double> orders{
      {"implicit_euler", 1}, {"implicit_midpoint", 2}, {"bdf2", 2}, {"tr_bdf2", 2}};
  for (const auto& [scheme, order] : orders) {
    ASSERT_GE(errors[scheme][0].size(), 3u) << scheme;
    EXPECT_NEAR(test::log_slope(errors[scheme][0], errors[scheme][1]), order, 0.15 * order) << scheme;
  }
}

TEST_F(SmallStudy, ResumesWithoutRunningAnythingTwice) {
  ASSERT_EQ(go("--quiet").code, 0);
  const std::string before = runs();
  const Outcome again = go("--resume");
  ASSERT_EQ(again.code, 0) << again.out;
  EXPECT_NE(again.out.find("runs are known"), std::string::npos) << again.out;
  EXPECT_EQ(again.out.find("reference: rk4, step halved 1 times\n"), std::string::npos);
  // What the first study left out for its budget may follow; what it had stands as it was, once.
  EXPECT_EQ(runs().compare(0, before.size(), before), 0);
  std::map<std::string, int> lines;
  std::ifstream stream(folder_ / "out/swing.runs.csv");
  for (std::string line; std::getline(stream, line);) {
    std::string key;
    int comma = 0;
    for (const char c : line) {
      comma += c == ',';
      if (comma < 10) key += c;
    }
    EXPECT_EQ(++lines[key], 1) << key;
  }
}

TEST_F(SmallStudy, MarksWhatDivergesAtItsStep) {
  // Explicit Euler gains energy at any step without damping.
  ASSERT_EQ(go("--quiet").code, 0);
  bool marked = false;
  for (const YAML::Node& run : result()["runs"]) {
    if (run["integrator"].as<std::string>() != "explicit_euler") continue;
    marked = marked || run["status"].as<std::string>() == "diverged";
    EXPECT_GT(run["dt_s"].as<double>(), 0.0);
    if (run["status"].as<std::string>() != "diverged") continue;
    EXPECT_TRUE(run["position_error"].IsNull());
    EXPECT_FALSE(run["note"].as<std::string>().empty());
  }
  EXPECT_TRUE(marked);
  for (const YAML::Node& k : result()["front"]) {
    EXPECT_EQ(result()["runs"][k.as<size_t>()]["status"].as<std::string>(), "done");
  }
}

TEST_F(SmallStudy, WritesASummaryForPrograms) {
  ASSERT_EQ(go("--quiet").code, 0);
  const YAML::Node summary = YAML::LoadFile(folder_ / "out/swing.summary.json");
  EXPECT_EQ(summary["features"]["kind"].as<std::string>(), "rope");
  EXPECT_EQ(summary["features"]["nodes"].as<int>(), 7);
  // E A / (rho A g L).
  EXPECT_NEAR(summary["features"]["stiffness_ratio"].as<double>(), 20.0 / (0.05 * 9.81), 1e-6);
  ASSERT_GE(summary["front"].size(), 2u);
  double before = 1e300;
  for (const YAML::Node& run : summary["front"]) {
    EXPECT_LT(run["position_error"].as<double>(), before);
    before = run["position_error"].as<double>();
  }
}

TEST(WorkPrecision, MeetsTheGoldenTable) {
  // The table is another program's, good to 1e-11 m; rk4 refined here must agree.
  const Folder folder("golden");
  ASSERT_EQ(study("golden_chain10_soft_damped --quick --quiet --budget 4 --out " + (folder / "out")).code, 0);
  const YAML::Node found = YAML::LoadFile(folder / "out/golden_chain10_soft_damped.json");
  EXPECT_EQ(found["reference"]["method"].as<std::string>(), "golden table");
  EXPECT_LT(found["reference"]["check_difference"].as<double>(), 1e-9);
}

TEST(WorkPrecision, RefusesBadOptionsByName) {
  for (const auto& [arguments, reason] : std::vector<std::array<std::string, 2>>{
           {"", "no scene given"},
           {"minimal --frobnicate", "unknown option --frobnicate"},
           {"minimal --seconds", "--seconds: needs a value"},
           {"minimal --seconds -1", "--seconds: '-1' is no time"},
           {"minimal --budget nan", "--budget: 'nan' is no time"},
           {"minimal --set gravity", "--set: 'gravity' is not KEY=VALUE"},
           {"minimal --set gravitas=1", "gravitas"},
           {"minimal --resume", "--resume: needs --out"},
           {"minimal curtain", "one scene at a time"},
           {"minimal --suite", "either --suite or a scene"},
           {"--suite --set gravity=0", "--set: changes one scene"},
           {"golden_ring16 --seconds 2", "--seconds: a golden trajectory has its own"},
           {"golden_ring16 --set gravity=0", "--set: a golden trajectory has no keys"},
           {"no_such_scene", "no scene 'no_such_scene'"}}) {
    const Outcome outcome = study(arguments);
    EXPECT_EQ(outcome.code, 2) << arguments << ": " << outcome.out;
    EXPECT_NE(outcome.out.find(reason), std::string::npos) << arguments << ": " << outcome.out;
  }
}

}  // namespace
}  // namespace deformable_sim::work_precision
