#include "deformable_sim/core/command_archive.h"

#include <utility>

#include "deformable_sim/core/archive.h"
#include "deformable_sim/core/contact/collider_set.h"
#include "deformable_sim/core/grasp/grasp_set.h"

namespace deformable_sim {
namespace {

struct Pass {
  Archive* archive;
  const std::vector<Collider>& known;

  void operator()(command::Grasp& c) const { pass_request(archive, &c.request); }
  void operator()(command::MoveGrasp& c) const {
    archive->pass(&c.name);
    archive->pass(&c.world_from_target);
    archive->pass(&c.duration);
  }
  void operator()(command::SetGraspWaiting& c) const {
    archive->pass(&c.name);
    archive->pass(&c.waiting);
  }
  void operator()(command::Release& c) const { archive->pass(&c.name); }
  void operator()(command::AddCollider& c) const { pass_collider(known, archive, &c.collider); }
  void operator()(command::MoveCollider& c) const {
    archive->pass(&c.name);
    archive->pass(&c.world_from_collider);
    archive->pass(&c.duration);
  }
  void operator()(command::RemoveCollider& c) const { archive->pass(&c.name); }
  void operator()(command::LetThrough& c) const {
    archive->pass(&c.name);
    archive->pass(&c.bodies);
  }
  void operator()(command::SetBodyState& c) const {
    archive->pass(&c.body);
    archive->pass(&c.x);
    archive->pass(&c.v);
    Nodes halves(3, 2 * c.rod.cols());  // of each segment's six numbers
    for (Eigen::Index k = 0; k < c.rod.cols(); ++k) {
      halves.col(2 * k) = c.rod.col(k).head<3>();
      halves.col(2 * k + 1) = c.rod.col(k).tail<3>();
    }
    archive->pass(&halves);
    if (!archive->reads()) return;
    if (halves.cols() % 2 != 0) Archive::refuse("half a segment");
    c.rod.resize(6, halves.cols() / 2);
    for (Eigen::Index k = 0; k < c.rod.cols(); ++k) c.rod.col(k) << halves.col(2 * k), halves.col(2 * k + 1);
  }
  void operator()(command::Reset&) const {}
};

/// The command with this place in the variant.
template <std::size_t... Kinds>
Command command_of(std::size_t kind, std::index_sequence<Kinds...>) {
  Command command;
  ((kind == Kinds ? (command.emplace<Kinds>(), true) : false) || ...);
  return command;
}

}  // namespace

std::string command_bytes(const Command& command) {
  Archive archive;
  auto kind = static_cast<int>(command.index());
  archive.pass(&kind);
  Command copy = command;
  const std::vector<Collider> none;
  std::visit(Pass{&archive, none}, copy);
  return archive.bytes();
}

Command read_command(const std::string& bytes, const std::vector<Collider>& known) {
  Archive archive(bytes);
  int kind = 0;
  archive.pass(&kind);
  constexpr auto kKinds = std::variant_size_v<Command>;
  if (kind < 0 || static_cast<std::size_t>(kind) >= kKinds) Archive::refuse("a command that does not exist");
  Command command = command_of(static_cast<std::size_t>(kind), std::make_index_sequence<kKinds>());
  std::visit(Pass{&archive, known}, command);
  archive.end();
  return command;
}

}  // namespace deformable_sim
