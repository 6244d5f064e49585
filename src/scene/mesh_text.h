// Words and numbers of a text file, each with its line.
#pragma once

#include <sstream>
#include <string>

namespace deformable_sim {

/// Reads a file word by word. Throws InputError "file:line: what".
class MeshText {
 public:
  /// `comment` starts a comment that lasts to the end of its line; 0 = there are none.
  MeshText(const std::string& path, char comment);
  /// Of `text`, whose first line is `first_line` of `name`.
  MeshText(const std::string& name, std::string text, int first_line, char comment);

  /// Whether no word is left.
  bool done();
  /// The next word; `what` names it when the file ends before it.
  std::string word(const std::string& what);
  double number(const std::string& what);
  /// Finite in single precision too.
  float coordinate();
  long integer(const std::string& what, long low, long high);
  /// Leaves out what remains of the line of the last word.
  void skip_line();
  /// Whether the next word stands on the line of the last one.
  bool more_on_line();
  /// Line of the last word.
  int line() const { return line_; }

  [[noreturn]] void refuse(const std::string& what) const { refuse_at(line_, what); }
  [[noreturn]] void refuse_at(int line, const std::string& what) const;

 private:
  void check_text();
  void skip_blank();

  std::string path_, text_;
  char comment_;
  size_t at_ = 0;
  int next_line_ = 1, line_ = 1;
  std::istringstream stream_;
};

}  // namespace deformable_sim
