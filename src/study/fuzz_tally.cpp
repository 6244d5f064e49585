#include "fuzz_tally.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <locale>
#include <map>
#include <sstream>

namespace deformable_sim::fuzz {
namespace {

constexpr std::array<const char*, 6> kEnds{"done", "cut", "refused", "stopped", "said", "failed"};

const char* name_of(Outcome::End end) {
  return kEnds[static_cast<size_t>(end)];
}

std::string quoted(std::string text) {
  std::replace(text.begin(), text.end(), '"', '\'');
  return "\"" + text + "\"";
}

template <class... Values>
std::string line(const char* form, Values... values) {
  char text[200];
  std::snprintf(text, sizeof text, form, values...);
  return text;
}

}  // namespace

void Tally::add(std::uint64_t seed, const Outcome& outcome, bool compared, bool patient) {
  entries_.push_back({seed, outcome, compared, patient});
}

int Tally::failures() const {
  return static_cast<int>(std::count_if(entries_.begin(), entries_.end(),
                                        [](const Entry& e) { return e.outcome.end == Outcome::End::kFound; }));
}

std::string Tally::text() const {
  std::map<Outcome::End, int> ends;
  std::map<std::string, int> kinds, schemes, stops, gains;
  double time = 0.0, cut_time = 0.0, cpu = 0.0;
  long steps = 0;
  int compared = 0, patient = 0, patient_cut = 0, by_auto = 0;
  for (const Entry& e : entries_) {
    const Outcome& o = e.outcome;
    ++ends[o.end];
    if (o.end == Outcome::End::kFound) ++kinds[o.what];
    if (o.end == Outcome::End::kStopped) ++stops[o.integrator];
    if (o.end == Outcome::End::kSaid) ++gains[o.integrator];
    if (o.end == Outcome::End::kSaid && o.what == kOfAuto) ++by_auto;
    if (o.end == Outcome::End::kCut) cut_time += o.time;
    if (!o.integrator.empty()) ++schemes[o.integrator];
    time += o.time;
    steps += o.steps;
    cpu += o.cpu;
    compared += e.compared ? 1 : 0;
    patient += e.patient ? 1 : 0;
    patient_cut += e.patient && o.end == Outcome::End::kCut ? 1 : 0;
  }
  const auto count = [&ends](Outcome::End end) { return ends.count(end) ? ends.at(end) : 0; };
  std::string text = line("scenes    %d, %.0f s simulated in %ld steps, %.0f s CPU; %d compared in their bits\n",
                          static_cast<int>(entries_.size()), time, steps, cpu, compared);
  text += line("done      %d\n", count(Outcome::End::kDone));
  text += line("cut       %d, too slow: %.2f s simulated in the mean\n", count(Outcome::End::kCut),
               cut_time / std::max(1, count(Outcome::End::kCut)));
  if (patient > 0) text += line("patient   %d were given more time, of which %d were cut\n", patient, patient_cut);
  text += line("refused   %d by the loader\n", count(Outcome::End::kRefused));
  const auto by_scheme = [&](const std::map<std::string, int>& counts) {
    std::string list;
    for (const auto& [name, n] : counts)
      list += line("%s %s %d of %d", list.empty() ? ":" : ",", name.c_str(), n, schemes[name]);
    return list + "\n";
  };
  text += line("stopped   %d by solvers that the scene names", count(Outcome::End::kStopped)) + by_scheme(stops);
  text += line("said      %d gains of energy that a warning gives, %d of them of auto", count(Outcome::End::kSaid),
               by_auto) +
          by_scheme(gains);
  text += line("failed    %d\n", failures());
  for (const auto& [kind, n] : kinds) {
    text += line("  %-16s %d, seeds", kind.c_str(), n);
    int named = 0;
    for (const Entry& e : entries_) {
      if (e.outcome.end != Outcome::End::kFound || e.outcome.what != kind || ++named > 8) continue;
      text += " " + std::to_string(e.seed);
    }
    text += "\n";
  }
  return text;
}

std::string Tally::csv() const {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text << "seed,end,what,integrator,time,steps,cpu,refused_commands,detail\n";
  for (const auto& [seed, o, compared, patient] : entries_) {
    text << seed << ',' << name_of(o.end) << ',' << o.what << ',' << o.integrator << ',' << o.time << ',' << o.steps
         << ',' << o.cpu << ',' << o.refused_commands << ',' << quoted(o.detail) << '\n';
  }
  return text.str();
}

}  // namespace deformable_sim::fuzz
