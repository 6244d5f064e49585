#include "collada_screen.h"

#include <algorithm>
#include <charconv>

#include "deformable_sim/core/error.h"

namespace deformable_sim {
namespace {

constexpr int kDeepest = 100;

bool starts(const std::string& text, size_t at, const char* what) {
  return text.compare(at, std::char_traits<char>::length(what), what) == 0;
}

/// One past the next `what`, or the end.
size_t after(const std::string& text, size_t at, const char* what) {
  const size_t found = text.find(what, at);
  return found == std::string::npos ? text.size() : found + std::char_traits<char>::length(what);
}

/// The `>` that ends the tag at `at`, not one in quotes.
size_t end_of_tag(const std::string& text, size_t at) {
  char quote = 0;
  for (; at < text.size(); ++at) {
    const char c = text[at];
    if (quote != 0) {
      if (c == quote) quote = 0;
    } else if (c == '"' || c == '\'') {
      quote = c;
    } else if (c == '>') {
      break;
    }
  }
  return at;
}

/// Elements whose text a reader takes for whole numbers until it ends: one letter among them keeps it from ending.
bool holds_indices(const std::string& tag) {
  const std::string name = tag.substr(1, tag.find_first_of(" \t\r\n/", 1) - 1);
  return name == "p" || name == "v" || name == "vcount" || name == "h";
}

void check_indices(const std::string& text, size_t begin, size_t end) {
  if (text.find_first_not_of("0123456789- \t\r\n", begin) < end) throw InputError("an index is no whole number");
}

void check_counts(const std::string& tag, size_t bytes) {
  for (size_t at = tag.find("count"); at != std::string::npos; at = tag.find("count", at + 1)) {
    const size_t equals = tag.find_first_not_of(" \t\r\n", at + 5);
    if (equals == std::string::npos || tag[equals] != '=') continue;
    const size_t digits = tag.find_first_of("\"'", equals);
    if (digits == std::string::npos) continue;
    const size_t end = tag.find(tag[digits], digits + 1);
    size_t count = 0;
    const char *first = tag.data() + digits + 1, *last = tag.data() + std::min(end, tag.size());
    const auto [stop, error] = std::from_chars(first, last, count);
    if (error != std::errc() || stop != last) throw InputError("a count is no whole number");
    if (count > bytes) throw InputError("claims " + std::to_string(count) + " values, more than the file has bytes");
  }
}

}  // namespace

void screen_collada(const std::string& text) {
  // A reader would take these for text of two or four bytes a letter, which is not what is screened here.
  if (text.find('\0') != std::string::npos) throw InputError("holds zero bytes; Collada is UTF-8 text");
  int depth = 0;
  bool indices = false;
  for (size_t at = text.find('<'), last = 0; at < text.size();
       last = at, at = std::min(text.find('<', at), text.size())) {
    if (indices && last > 0) check_indices(text, last, at);
    if (starts(text, at, "<!--")) {
      at = after(text, at + 4, "-->");
    } else if (starts(text, at, "<![CDATA[")) {
      if (indices) throw InputError("an index is no whole number");
      at = after(text, at, "]]>");
    } else if (starts(text, at, "<?")) {
      at = after(text, at, "?>");
    } else if (starts(text, at, "<!")) {
      throw InputError("a document type in the file; Collada needs none");
    } else {
      const size_t end = end_of_tag(text, at);
      const std::string tag = text.substr(at, end - at);
      if (starts(tag, 0, "</")) {
        --depth;
      } else if (tag.back() != '/' && ++depth > kDeepest) {
        throw InputError("elements nested deeper than " + std::to_string(kDeepest));
      }
      if (tag.find("instance_node") != std::string::npos) {
        throw InputError("instance_node is not read; save the file with each part where it is used");
      }
      check_counts(tag, text.size());
      if (indices && !starts(tag, 0, "</")) throw InputError("an element among indices");
      indices = !starts(tag, 0, "</") && tag.back() != '/' && holds_indices(tag);
      at = std::min(end + 1, text.size());
    }
  }
}

}  // namespace deformable_sim
