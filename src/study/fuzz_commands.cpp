#include "fuzz_commands.h"

#include <algorithm>
#include <locale>
#include <sstream>

#include "deformable_sim/core/error.h"
#include "fuzz_random.h"

namespace deformable_sim::fuzz {
namespace {

const char kMark[] = "#!";

/// Reads names and numbers off a command in order.
class Words {
 public:
  explicit Words(const TimedCommand& command) : command_(command) {}
  std::string name() {
    if (name_ == command_.names.size()) throw InputError("#! " + command_.word + ": a name is missing");
    return command_.names[name_++];
  }
  double number() {
    if (number_ == command_.numbers.size()) throw InputError("#! " + command_.word + ": a number is missing");
    return command_.numbers[number_++];
  }
  Vec3 vector() {
    Vec3 v;
    for (double& value : v) value = number();
    return v;
  }
  Pose pose() {
    const Vec3 p = vector(), rpy = vector();
    Pose pose = Pose::Identity();
    pose.linear() = (Eigen::AngleAxisd(rpy[2], Vec3::UnitZ()) * Eigen::AngleAxisd(rpy[1], Vec3::UnitY()) *
                     Eigen::AngleAxisd(rpy[0], Vec3::UnitX()))
                        .toRotationMatrix();
    pose.translation() = p;
    return pose;
  }

 private:
  const TimedCommand& command_;
  size_t name_ = 0, number_ = 0;
};

command::Grasp grasp_of(Words words) {
  GraspRequest request;
  request.name = words.name();
  request.body = words.name();
  const std::string how = words.name();
  Selection& selection = request.selection;
  selection.world_from_selection.translation() = words.vector();
  const double size = words.number();
  selection.method = how == "radius" ? SelectionMethod::kRadius
                     : how == "box"  ? SelectionMethod::kBox
                                     : SelectionMethod::kNearest;
  selection.radius = size;
  selection.size.setConstant(size);
  request.max_force = words.number();
  request.stiffness = words.number();
  return {request};
}

command::AddCollider collider_of(Words words) {
  Collider collider;
  collider.name = words.name();
  const std::string type = words.name();
  collider.world_from_collider.translation() = words.vector();
  const double size = words.number();
  collider.friction = words.number();
  Shape shape;
  shape.type = type == "sphere"    ? Shape::Type::kSphere
               : type == "capsule" ? Shape::Type::kCapsule
               : type == "plane"   ? Shape::Type::kPlane
                                   : Shape::Type::kBox;
  shape.size.setConstant(size);
  collider.shapes.push_back(shape);
  return {collider};
}

/// The columns of a body, of `world`.
struct BodyColumns {
  BodyColumns(const World& world, const std::string& name) {
    const int index = world.model().find_body(name);
    if (index < 0) throw InputError("no body '" + name + "'", Code::kNotFound);
    const Body& body = world.model().bodies[static_cast<size_t>(index)];
    state.body = name;
    state.x = world.state().x.middleCols(body.first_node, body.node_count);
    state.v = world.state().v.middleCols(body.first_node, body.node_count);
  }
  command::SetBodyState state;
};

command::SetBodyState state_of(Words words, const World& world) {
  BodyColumns body(world, words.name());
  const double scale = words.number();
  const Vec3 shift = words.vector(), velocity = words.vector();
  const Vec3 mean = body.state.x.rowwise().mean();
  body.state.x = (scale * (body.state.x.colwise() - mean)).colwise() + (mean + shift);
  body.state.v.colwise() = velocity;
  return body.state;
}

command::SetBodyState scattered(Words words, const World& world) {
  BodyColumns body(world, words.name());
  const double size = words.number();
  Random random(static_cast<std::uint64_t>(words.number()));
  const Vec3 mean = body.state.x.rowwise().mean();
  for (Eigen::Index i = 0; i < body.state.x.cols(); ++i) {
    for (Eigen::Index k = 0; k < 3; ++k) body.state.x(k, i) = mean[k] + size * random.uniform(-0.5, 0.5);
  }
  body.state.v.setZero();
  return body.state;
}

}  // namespace

std::vector<TimedCommand> commands_of(const std::string& text) {
  std::vector<TimedCommand> commands;
  std::istringstream lines(text);
  std::string line;
  while (std::getline(lines, line)) {
    if (line.rfind(kMark, 0) != 0) continue;
    std::istringstream words(line.substr(2));
    words.imbue(std::locale::classic());
    TimedCommand command;
    if (!(words >> command.time >> command.word)) throw InputError("'" + line + "': needs a time and a word");
    std::string word;
    while (words >> word) {
      std::istringstream number(word);
      number.imbue(std::locale::classic());
      double value = 0.0;
      if (number >> value && number.eof()) {
        command.numbers.push_back(value);
      } else {
        command.names.push_back(word);
      }
    }
    commands.push_back(command);
  }
  std::stable_sort(commands.begin(), commands.end(), [](const auto& a, const auto& b) { return a.time < b.time; });
  return commands;
}

Reply apply(const TimedCommand& c, World* world) {
  Words words(c);
  if (c.word == "grasp") return world->apply(grasp_of(words));
  if (c.word == "add_collider") return world->apply(collider_of(words));
  if (c.word == "set_state") return world->apply(state_of(words, *world));
  if (c.word == "scatter") return world->apply(scattered(words, *world));
  if (c.word == "reset") return world->apply(command::Reset{});
  const std::string name = words.name();
  if (c.word == "release") return world->apply(command::Release{name});
  if (c.word == "remove_collider") return world->apply(command::RemoveCollider{name});
  if (c.word == "let_through") return world->apply(command::LetThrough{name, {words.name()}});
  const bool grasp = c.word == "move_grasp";
  if (!grasp && c.word != "move_collider") throw InputError("#! '" + c.word + "' is no command");
  const Pose pose = words.pose();
  const double duration = words.number();
  if (grasp) return world->apply(command::MoveGrasp{name, pose, duration});
  return world->apply(command::MoveCollider{name, pose, duration});
}

}  // namespace deformable_sim::fuzz
