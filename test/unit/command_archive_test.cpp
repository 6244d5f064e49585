#include "deformable_sim/core/command_archive.h"

#include <gtest/gtest.h>

#include "deformable_sim/core/error.h"

namespace deformable_sim::test {
namespace {

Pose somewhere() {
  Pose pose(Eigen::AngleAxisd(0.3, Vec3(1, 2, 2).normalized()));
  pose.translation() = Vec3(0.1, -1.0 / 3.0, 7.0);
  return pose;
}

Collider ball() {
  Collider collider;
  collider.name = "ball";
  Shape shape;
  shape.type = Shape::Type::kSphere;
  shape.size = Vec3(0.1, 0, 0);
  collider.shapes.push_back(shape);
  collider.world_from_collider = somewhere();
  collider.lets_through = {"sheet"};
  return collider;
}

/// One of every kind, with nothing at its default.
std::vector<Command> all_kinds() {
  GraspRequest grasp;
  grasp.name = "hand";
  grasp.body = "sheet";
  grasp.selection.method = SelectionMethod::kNodes;
  grasp.selection.nodes = {3, 5};
  grasp.has_frame = true;
  grasp.world_from_grasp = somewhere();
  grasp.max_force = 1.0 / 3.0;
  command::SetBodyState state{"sheet", Nodes::Random(3, 4), Nodes::Random(3, 4)};
  state.rod = RodState::Random(6, 2);
  return {command::Grasp{grasp},
          command::MoveGrasp{"hand", somewhere(), 0.1},
          command::SetGraspWaiting{"hand", true},
          command::Release{"hand"},
          command::AddCollider{ball()},
          command::MoveCollider{"ball", somewhere(), 0.7},
          command::RemoveCollider{"ball"},
          command::LetThrough{"ball", {"sheet", "rope"}},
          state,
          command::Reset{}};
}

TEST(CommandArchive, GivesEveryKindBack) {
  const std::vector<Command> commands = all_kinds();
  ASSERT_EQ(commands.size(), std::variant_size_v<Command>);
  for (const Command& command : commands) {
    const std::string bytes = command_bytes(command);
    const Command read = read_command(bytes, {});
    EXPECT_EQ(read.index(), command.index());
    EXPECT_EQ(command_bytes(read), bytes) << command.index();
  }
  const auto move = std::get<command::MoveGrasp>(read_command(command_bytes(commands[1]), {}));
  EXPECT_EQ(move.name, "hand");
  EXPECT_EQ(move.world_from_target.matrix(), somewhere().matrix());
  EXPECT_EQ(move.duration, 0.1);
  const auto state = std::get<command::SetBodyState>(read_command(command_bytes(commands[8]), {}));
  const auto given = std::get<command::SetBodyState>(commands[8]);
  EXPECT_EQ(state.x, given.x);
  EXPECT_EQ(state.v, given.v);
  EXPECT_EQ(state.rod, given.rod);
  const auto add = std::get<command::AddCollider>(read_command(command_bytes(commands[4]), {}));
  EXPECT_EQ(add.collider.lets_through, ball().lets_through);
  EXPECT_EQ(add.collider.shapes.at(0).size, ball().shapes[0].size);
}

TEST(CommandArchive, RefusesWhatIsCutLongerOrOfNoKind) {
  for (const Command& command : all_kinds()) {
    const std::string bytes = command_bytes(command);
    for (std::size_t length = 0; length < bytes.size(); ++length)
      EXPECT_THROW(read_command(bytes.substr(0, length), {}), InputError) << command.index() << " cut to " << length;
    EXPECT_THROW(read_command(bytes + "x", {}), InputError);
  }
  for (const char kind : {char(10), char(-1)}) {
    std::string bytes = command_bytes(command::Reset{});
    bytes[0] = kind;
    EXPECT_THROW(read_command(bytes, {}), InputError) << int(kind);
  }
}

}  // namespace
}  // namespace deformable_sim::test
