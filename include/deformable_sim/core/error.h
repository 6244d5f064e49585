// Outcome of a request. User mistakes are refused with a Status and change nothing.
#pragma once

#include <stdexcept>
#include <string>
#include <utility>

namespace deformable_sim {

/// Values equal those of Status.msg.
enum class Code {
  kOk = 0,
  kInvalidArgument = 1,
  kNotFound = 2,
  kAlreadyExists = 3,
  kUnavailable = 4,
  kTimeout = 5,
  kOutOfRange = 6,
  kInternal = 7,
};

/// What became of a request; `message` says what was wrong and what is allowed, empty when kOk.
struct Status {
  Code code = Code::kOk;
  std::string message;

  bool ok() const { return code == Code::kOk; }
};

/// A refused input, thrown by builders and loaders.
class InputError : public std::runtime_error {
 public:
  explicit InputError(const std::string& what, Code code = Code::kInvalidArgument)
      : std::runtime_error(what), code_(code) {}
  Code code() const { return code_; }

 private:
  Code code_;
};

}  // namespace deformable_sim
