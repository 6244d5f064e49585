#include "mesh_text.h"

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <locale>
#include <utility>

#include "deformable_sim/core/error.h"

namespace deformable_sim {
namespace {

constexpr std::uintmax_t kMaxMeshBytes = 256u << 20;

bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == '\v' || c == '\f';
}

/// At most 30 characters that can be printed: what a message quotes of a file.
std::string quoted(const std::string& word) {
  std::string text;
  for (const char c : word.substr(0, 30)) text += c > ' ' && c < 0x7f ? c : '?';
  return "'" + text + (word.size() > 30 ? "...'" : "'");
}

}  // namespace

MeshText::MeshText(const std::string& path, char comment) : path_(path), comment_(comment) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) throw InputError(path + ": no such mesh file", Code::kNotFound);
  if (std::filesystem::file_size(path, error) > kMaxMeshBytes) {
    throw InputError(path + ": larger than " + std::to_string(kMaxMeshBytes >> 20) + " MiB", Code::kOutOfRange);
  }
  std::ifstream file(path, std::ios::binary);
  std::ostringstream all;
  all << file.rdbuf();
  if (!file) throw InputError(path + ": cannot be read", Code::kNotFound);
  text_ = all.str();
  check_text();
}

MeshText::MeshText(const std::string& name, std::string text, int first_line, char comment)
    : path_(name), text_(std::move(text)), comment_(comment), next_line_(first_line), line_(first_line) {
  check_text();
}

void MeshText::check_text() {
  if (text_.find('\0') != std::string::npos) {
    throw InputError(path_ + ": is binary; a text (ASCII) file is allowed");
  }
  stream_.imbue(std::locale::classic());
}

void MeshText::skip_blank() {
  for (; at_ < text_.size(); ++at_) {
    if (comment_ != 0 && text_[at_] == comment_) {
      while (at_ < text_.size() && text_[at_] != '\n') ++at_;
      if (at_ == text_.size()) return;
    }
    if (!is_blank(text_[at_])) return;
    if (text_[at_] == '\n') ++next_line_;
  }
}

bool MeshText::done() {
  skip_blank();
  return at_ >= text_.size();
}

bool MeshText::more_on_line() {
  return !done() && next_line_ == line_;
}

std::string MeshText::word(const std::string& what) {
  if (done()) refuse("the file ends where " + what + " should stand");
  line_ = next_line_;
  const size_t first = at_;
  while (at_ < text_.size() && !is_blank(text_[at_]) && (comment_ == 0 || text_[at_] != comment_)) ++at_;
  return text_.substr(first, at_ - first);
}

double MeshText::number(const std::string& what) {
  const std::string text = word(what);
  double value = 0.0;
  stream_.clear();
  stream_.str(text);
  stream_ >> value;
  if (!stream_ || !stream_.eof() || !std::isfinite(value)) {
    refuse(what + " must be a finite number, not " + quoted(text));
  }
  return value;
}

float MeshText::coordinate() {
  const double value = number("a coordinate");
  if (std::abs(value) > std::numeric_limits<float>::max()) refuse("a coordinate is too large");
  return static_cast<float>(value) + 0.0F;  // -0 becomes +0
}

long MeshText::integer(const std::string& what, long low, long high) {
  const std::string text = word(what);
  long value = 0;
  stream_.clear();
  stream_.str(text);
  stream_ >> value;
  if (!stream_ || !stream_.eof()) refuse(what + " must be a whole number, not " + quoted(text));
  if (value < low || value > high) {
    refuse(what + " " + text + " is out of range; allowed: " + std::to_string(low) + " ... " + std::to_string(high));
  }
  return value;
}

void MeshText::skip_line() {
  while (at_ < text_.size() && text_[at_] != '\n') ++at_;
}

void MeshText::refuse_at(int line, const std::string& what) const {
  throw InputError(path_ + ":" + std::to_string(line) + ": " + what);
}

}  // namespace deformable_sim
