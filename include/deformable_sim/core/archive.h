// The bytes of a saved state, written and read back by the same function.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "deformable_sim/core/types.h"

namespace deformable_sim {

/// Whatever belongs to a saved state has one function pass(Archive*, T*) that hands its members to the archive in
/// order: when writing they are appended, when reading they are replaced, so that the two cannot differ.
///
/// Numbers are kept to the last bit, in the byte order of the machine. Reading trusts nothing: a count is refused
/// before memory is taken for more than the bytes that are left can hold, a number that is not finite is refused (but
/// by pass_any), all by InputError. It does not find out what a number means: whoever passes an index or a length
/// checks it.
class Archive {
 public:
  /// Writes.
  Archive() = default;
  /// Reads.
  explicit Archive(std::string bytes) : bytes_(std::move(bytes)), reads_(true) {}

  /// Writes what goes on as if it had not been written: it keeps what it would else make anew, as its copy will.
  static Archive looking_on() {
    Archive archive;
    archive.looks_on_ = true;
    return archive;
  }

  bool reads() const { return reads_; }
  bool looks_on() const { return looks_on_; }
  /// What was written.
  const std::string& bytes() const { return bytes_; }
  /// Reading is over. Throws InputError when something is left.
  void end() const;
  /// Throws InputError.
  [[noreturn]] static void refuse(const std::string& what);

  void pass(double* value);
  void pass_any(double* value);  // finite or not
  void pass(int* value) { pass_raw(value, sizeof *value); }
  void pass(std::int64_t* value) { pass_raw(value, sizeof *value); }
  void pass(std::uint64_t* value) { pass_raw(value, sizeof *value); }
  void pass(bool* value);
  void pass(std::string* text);
  void pass(Vec3* v);
  void pass(Pose* pose);  // finite, within 1e6 m, a rotation
  void pass(Nodes* x);    // of any size
  void pass(Eigen::VectorXd* x);
  /// `value` is one of 0 ... most.
  template <class Enum>
  void pass_enum(Enum* value, Enum most) {
    int number = static_cast<int>(*value);
    pass(&number);
    if (number < 0 || number > static_cast<int>(most)) refuse("a kind that does not exist");
    *value = static_cast<Enum>(number);
  }
  /// each(&item) for every item, each of which takes `least` bytes or more.
  template <class T, class Each>
  void pass_each(std::vector<T>* list, std::size_t least, const Each& each) {
    list->resize(pass_count(list->size(), least));
    for (T& item : *list) each(&item);
  }
  void pass(std::vector<int>* list) {
    pass_each(list, sizeof(int), [this](int* item) { pass(item); });
  }
  void pass(std::vector<std::string>* list) {
    pass_each(list, sizeof(std::uint64_t), [this](std::string* item) { pass(item); });
  }
  /// A number of things that take `least` bytes or more each.
  std::size_t pass_count(std::size_t count, std::size_t least);

 private:
  void pass_raw(void* data, std::size_t size);

  std::string bytes_;
  std::size_t at_ = 0;
  bool reads_ = false, looks_on_ = false;
};

}  // namespace deformable_sim
