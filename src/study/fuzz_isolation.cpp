// A case in a process of its own.
#include <algorithm>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <locale>
#include <sstream>

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "deformable_sim/core/error.h"
#include "fuzz_run.h"

namespace deformable_sim::fuzz {
namespace {

constexpr double kHang = 10.0;  // CPU s beyond the limit of a run, which is looked at between steps
constexpr int kRuns = 14;       // of compare_case(), at most, in limits of one

std::string on_one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  std::replace(text.begin(), text.end(), '\t', ' ');
  return text;
}

std::string text_of(const Outcome& o) {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text.precision(17);
  text << static_cast<int>(o.end) << '\t' << o.what << '\t' << on_one_line(o.detail) << '\t' << o.integrator << '\t'
       << o.time << '\t' << o.steps << '\t' << o.refused_commands << '\t' << o.cpu << '\t' << o.bits << '\n';
  return text.str();
}

bool read(const std::string& text, Outcome* o) {
  if (text.empty() || text.back() != '\n') return false;
  std::istringstream fields(text);
  std::string end, rest;
  std::getline(fields, end, '\t');
  std::getline(fields, o->what, '\t');
  std::getline(fields, o->detail, '\t');
  std::getline(fields, o->integrator, '\t');
  fields.imbue(std::locale::classic());
  fields >> o->time >> o->steps >> o->refused_commands >> o->cpu >> o->bits;
  o->end = static_cast<Outcome::End>(std::stoi(end));
  return static_cast<bool>(fields);
}

void send(int to, const std::string& line) {
  if (write(to, line.data(), line.size()) != static_cast<ssize_t>(line.size())) _exit(1);
}

[[noreturn]] void work(int to, const std::string& text, const std::string& origin, const Limits& limits, Depth depth) {
  const double runs = depth == Depth::kOnce ? 1.0 : kRuns;
  const auto most = static_cast<rlim_t>(std::ceil(kHang + runs * limits.cpu));
  const rlimit cpu{most, most + 1};
  setrlimit(RLIMIT_CPU, &cpu);
  const rlimit no_core{0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
  Limits told = limits;
  told.begins = [&](const std::string& integrator, bool any_cost) {
    send(to, (any_cost ? "any " : "some ") + integrator + "\n");
    if (limits.begins) limits.begins(integrator, any_cost);
  };
  send(to, text_of(depth == Depth::kOnce ? run_case(text, origin, told) : compare_case(text, origin, told)));
  _exit(0);
}

std::string read_all(int from) {
  std::string text;
  char part[4096];
  for (ssize_t n = 0; (n = ::read(from, part, sizeof part)) > 0;) text.append(part, static_cast<size_t>(n));
  return text;
}

}  // namespace

Outcome run_isolated(const std::string& text, const std::string& origin, const Limits& limits, Depth depth) {
  int ends[2];
  if (pipe(ends) != 0) throw InputError("no pipe to a process of its own: " + std::string(std::strerror(errno)));
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child < 0) throw InputError("no process of its own: " + std::string(std::strerror(errno)));
  if (child == 0) {
    close(ends[0]);
    work(ends[1], text, origin, limits, depth);
  }
  close(ends[1]);
  const std::string answer = read_all(ends[0]);
  close(ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  // First a line of who steps, unless there was no world, then that of the outcome.
  const size_t end_of_line = answer.find('\n');
  const bool began = answer.rfind("any ", 0) == 0 || answer.rfind("some ", 0) == 0;
  Outcome outcome;
  const std::string last = began ? answer.substr(end_of_line + 1) : answer;
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0 && read(last, &outcome)) return outcome;
  outcome = Outcome();
  if (began) outcome.integrator = answer.substr(answer.find(' ') + 1, end_of_line - answer.find(' ') - 1);
  const bool hung = WIFSIGNALED(status) && (WTERMSIG(status) == SIGXCPU || WTERMSIG(status) == SIGKILL);
  outcome.end = hung && answer.rfind("any ", 0) == 0 ? Outcome::End::kCut : Outcome::End::kFound;
  outcome.what = outcome.end == Outcome::End::kCut ? "slow step" : hung ? "hang" : "crash";
  outcome.detail =
      WIFSIGNALED(status) ? strsignal(WTERMSIG(status)) : "ended with status " + std::to_string(WEXITSTATUS(status));
  return outcome;
}

}  // namespace deformable_sim::fuzz
