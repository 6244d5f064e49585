#include "deformable_sim/scene/run_report.h"

#include <cmath>
#include <cstdio>

namespace deformable_sim {
namespace {

std::string number(double value) {
  if (!std::isfinite(value)) return "null";
  char text[32];
  std::snprintf(text, sizeof text, "%.17g", value);
  return text;
}

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (static_cast<unsigned char>(c) < 0x20) {
      char code[8];
      std::snprintf(code, sizeof code, "\\u%04x", static_cast<unsigned>(c));
      out += code;
    } else {
      out += c;
    }
  }
  return out + "\"";
}

std::string vector(const Vec3& v) {
  return "[" + number(v.x()) + ", " + number(v.y()) + ", " + number(v.z()) + "]";
}

std::string member(const std::string& key, const std::string& value) {
  return quoted(key) + ": " + value;
}

std::string body_json(const Snapshot& s, size_t index) {
  const Body& body = s.model->bodies[index];
  const BodyReport& report = s.bodies[index];
  const auto x = s.x.middleCols(body.first_node, body.node_count);
  const auto mass = s.model->mass.segment(body.first_node, body.node_count);
  const Vec3 center = x * mass / mass.sum();
  return "{" + member("nodes", std::to_string(body.node_count)) + ", " +
         member("max_strain", number(report.max_strain)) + ", " + member("min_strain", number(report.min_strain)) +
         ", " +
         member("energies", "{" + member("kinetic", number(report.kinetic_energy)) + ", " +
                                member("elastic", number(report.elastic_energy)) + ", " +
                                member("potential", number(report.potential_energy)) + "}") +
         ", " +
         member("bounds", "{" + member("min", vector(x.rowwise().minCoeff())) + ", " +
                              member("max", vector(x.rowwise().maxCoeff())) + "}") +
         ", " + member("center_of_mass", vector(center)) + "}";
}

const char* phase_name(GraspPhase phase) {
  switch (phase) {
    case GraspPhase::kHolding:
      return "holding";
    case GraspPhase::kSlipped:
      return "slipped";
    case GraspPhase::kWaitingForFrame:
      return "waiting_for_frame";
  }
  return "";
}

template <class... Values>
std::string line(const char* form, Values... values) {
  char text[256];
  std::snprintf(text, sizeof text, form, values...);
  return text;
}

}  // namespace

std::string run_summary(const RunReport& report) {
  const Snapshot& s = report.last;
  std::string text;
  text += line("simulated   %.3f s in %llu steps of %g s (%s)\n", s.time, static_cast<unsigned long long>(s.step), s.dt,
               s.integrator.c_str());
  if (!report.solver.empty()) text += "solver      " + report.solver + "\n";
  text += line("cost        %.3f s CPU, %.3f s wall, real-time factor %.2f\n", report.cpu_seconds, report.wall_seconds,
               report.real_time_factor());
  text += line("strain      largest %.2f %%\n", 100 * report.max_strain);
  text += line("penetration largest %.3f mm\n", 1000 * report.max_penetration);
  for (size_t b = 0; b < s.bodies.size(); ++b) {
    const BodyReport& body = s.bodies[b];
    text += "body        " + s.model->bodies[b].name +
            line(": %d nodes, strain %.2f ... %.2f %%, energy kinetic %.3g J, elastic %.3g J, potential %.4g J\n",
                 s.model->bodies[b].node_count, 100 * body.min_strain, 100 * body.max_strain, body.kinetic_energy,
                 body.elastic_energy, body.potential_energy);
  }
  for (const GraspReport& grasp : s.grasps) {
    text += "grasp       " + grasp.name +
            line(": force [%.4g, %.4g, %.4g] N, torque [%.3g, %.3g, %.3g] N m, ", grasp.force.x(), grasp.force.y(),
                 grasp.force.z(), grasp.torque.x(), grasp.torque.y(), grasp.torque.z()) +
            phase_name(grasp.phase) + "\n";
  }
  for (const std::string& warning : s.warnings) text += "warning     " + warning + "\n";
  for (const BillItem& item : report.bill) {
    text += "bill        " + item.part + ": " + item.detail + line(", %.1f %%\n", 100 * item.share);
  }
  return text;
}

std::string run_json(const RunReport& report) {
  const Snapshot& s = report.last;
  std::string bodies, grasps, warnings, bill;
  for (size_t b = 0; b < s.bodies.size(); ++b) {
    bodies += (b ? ", " : "") + member(s.model->bodies[b].name, body_json(s, b));
  }
  for (size_t g = 0; g < s.grasps.size(); ++g) {
    const GraspReport& grasp = s.grasps[g];
    grasps += (g ? ", " : "") + member(grasp.name, "{" + member("force", vector(grasp.force)) + ", " +
                                                       member("torque", vector(grasp.torque)) + ", " +
                                                       member("state", quoted(phase_name(grasp.phase))) + "}");
  }
  for (size_t k = 0; k < s.warnings.size(); ++k) warnings += (k ? ", " : "") + quoted(s.warnings[k]);
  for (size_t k = 0; k < report.bill.size(); ++k) {
    const BillItem& item = report.bill[k];
    bill += (k ? ", " : "") + ("{" + member("part", quoted(item.part)) + ", " + member("detail", quoted(item.detail)) +
                               ", " + member("share", number(item.share)) + "}");
  }
  return "{" + member("scene", quoted(report.scene)) + ", " + member("error", quoted(report.error)) + ", " +
         member("time", number(s.time)) + ", " + member("steps", std::to_string(s.step)) + ", " +
         member("dt", number(s.dt)) + ", " + member("integrator", quoted(s.integrator)) + ", " +
         member("solver", quoted(report.solver)) + ", " + member("cpu_seconds", number(report.cpu_seconds)) + ", " +
         member("wall_seconds", number(report.wall_seconds)) + ", " +
         member("real_time_factor", number(report.real_time_factor())) + ", " + member("bodies", "{" + bodies + "}") +
         ", " + member("grasps", "{" + grasps + "}") + ", " +
         member("max_penetration", number(report.max_penetration)) + ", " +
         member("max_strain", number(report.max_strain)) + ", " + member("warnings", "[" + warnings + "]") + ", " +
         member("bill", "[" + bill + "]") + "}";
}

}  // namespace deformable_sim
