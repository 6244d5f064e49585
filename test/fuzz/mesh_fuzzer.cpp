// libFuzzer program for files of triangles and tetrahedra.
#include <cctype>
#include <random>

#include "fuzz/libfuzzer.h"
#include "fuzz/targets.h"

namespace fuzz = deformable_sim::fuzz;

namespace {

const char* const kNumbers[] = {
    "0",    "-1",    "1",   "2",          "3",          "1e308",      "1e39", "nan",
    "-inf", "1e-45", "0x1", "4294967295", "4000000000", "2147483648", "-5",   "99999999999999999999",
    "1.5",  "",      "1/1", "1//",        "-1/-1/-1",   "1000000",    "7",    "0.1"};
const char* const kFormats[] = {"obj", "stl", "ply", "dae", "msh", "mesh", "tetgen"};

/// Puts an extreme number in the place of one.
std::string change_number(const std::string& text, std::mt19937* random) {
  const auto below = [random](std::size_t n) { return std::uniform_int_distribution<std::size_t>(0, n - 1)(*random); };
  const auto is_of_number = [](char c) { return std::isdigit(static_cast<unsigned char>(c)) || c == '.' || c == '-'; };
  for (int tries = 0; tries < 50 && !text.empty(); ++tries) {
    std::size_t begin = below(text.size()), end = begin;
    while (begin > 0 && is_of_number(text[begin - 1])) --begin;
    while (end < text.size() && is_of_number(text[end])) ++end;
    if (begin >= end) continue;
    return text.substr(0, begin) + kNumbers[below(sizeof kNumbers / sizeof *kNumbers)] + text.substr(end);
  }
  return text;
}

/// Leaves a line out, or gives it twice.
std::string change_line(const std::string& text, std::mt19937* random) {
  if (text.empty()) return text;
  const std::size_t at = std::uniform_int_distribution<std::size_t>(0, text.size() - 1)(*random);
  const std::size_t before = text.rfind('\n', at), after = std::min(text.find('\n', at), text.size());
  const std::size_t begin = before == std::string::npos || before >= after ? 0 : before + 1;
  const std::string line = text.substr(begin, after - begin);
  return text.substr(0, begin) + ((*random)() % 2 == 0 ? "" : line + "\n" + line) + text.substr(after);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::try_mesh({reinterpret_cast<const char*>(data), size});
  return 0;
}

/// Half of the changes are of bytes; the others of numbers, lines and the format.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned seed) {
  std::mt19937 random(seed);
  std::string text(reinterpret_cast<const char*>(data), size);
  switch (seed % 8) {
    case 0:
    case 1:
      text = change_number(text, &random);
      break;
    case 2:
      text = change_line(text, &random);
      break;
    case 3:
      if (seed % 64 == 3) {
        const std::size_t end = std::min(text.find('\n'), text.size());
        text = kFormats[random() % (sizeof kFormats / sizeof *kFormats)] + text.substr(end);
      } else {
        text = change_number(change_line(text, &random), &random);
      }
      break;
    default:
      return LLVMFuzzerMutate(data, size, max_size);
  }
  return fuzz::give_back(text, max_size, data);
}
