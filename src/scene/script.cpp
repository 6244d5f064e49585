#include "deformable_sim/scene/script.h"

#include "schema.h"

namespace deformable_sim {

std::string said_of(const ScriptEvent& event, const std::string& what) {
  const std::string place =
      event.where.line > 0 ? event.where.file + ":" + std::to_string(event.where.line) : event.where.file;
  return place + ": " + event.path + ": at " + format_number(event.time) + " s: " + what;
}

void Script::go_on_after(std::size_t events) {
  if (events > events_.size()) throw InputError("saved state: of a script with more events");
  next_ = events;
}

void Script::go_on_like(const Script& other) {
  next_ = events_.size();
  if (other.next_ == other.events_.size()) return;
  const double left = other.events_[other.next_].time;  // all before are taken, and those of one time together
  for (next_ = 0; next_ < events_.size() && events_[next_].time < left;) ++next_;
}

Reply play(Script* script, World* world) {
  Reply all;
  while (const ScriptEvent* event = script->take(world->time())) {
    Reply reply = world->apply(event->command);
    if (!reply.status.ok()) {
      reply.status.message = said_of(*event, reply.status.message);
      return reply;
    }
    if (!reply.note.empty()) all.note += (all.note.empty() ? "" : "\n") + said_of(*event, reply.note);
  }
  return all;
}

}  // namespace deformable_sim
