#include "deformable_sim/core/archive.h"

#include <cmath>
#include <cstring>

#include "deformable_sim/core/error.h"
#include "deformable_sim/core/frame_motion.h"

namespace deformable_sim {

void Archive::refuse(const std::string& what) {
  throw InputError("saved state: " + what);
}

void Archive::end() const {
  if (at_ != bytes_.size()) refuse("it goes on where it should end");
}

void Archive::pass_raw(void* data, std::size_t size) {
  if (size == 0) return;  // of nothing, `data` may be null
  if (!reads_) {
    bytes_.append(static_cast<const char*>(data), size);
    return;
  }
  if (size > bytes_.size() - at_) refuse("it ends too early");
  std::memcpy(data, bytes_.data() + at_, size);
  at_ += size;
}

std::size_t Archive::pass_count(std::size_t count, std::size_t least) {
  std::uint64_t number = count;
  pass(&number);
  if (reads_ && number > (bytes_.size() - at_) / least) refuse("it ends too early");
  return static_cast<std::size_t>(number);
}

void Archive::pass_any(double* value) {
  pass_raw(value, sizeof *value);
}

void Archive::pass(double* value) {
  pass_raw(value, sizeof *value);
  if (reads_ && !std::isfinite(*value)) refuse("a number that is not finite");
}

void Archive::pass(bool* value) {
  int number = *value ? 1 : 0;
  pass(&number);
  if (number != 0 && number != 1) refuse("a truth value that is neither");
  *value = number == 1;
}

void Archive::pass(std::string* text) {
  text->resize(pass_count(text->size(), 1));
  pass_raw(text->data(), text->size());
}

void Archive::pass(Vec3* v) {
  for (int k = 0; k < 3; ++k) pass(v->data() + k);
}

void Archive::pass(Pose* pose) {
  for (int column = 0; column < 4; ++column)
    for (int row = 0; row < 3; ++row) pass(&pose->matrix()(row, column));
  if (!reads_) return;
  pose->makeAffine();
  if (!is_valid_pose(*pose)) refuse("a pose that is none");
}

void Archive::pass(Nodes* x) {
  const auto columns = static_cast<Eigen::Index>(pass_count(static_cast<std::size_t>(x->cols()), 3 * sizeof(double)));
  x->resize(3, columns);
  pass_raw(x->data(), static_cast<std::size_t>(x->size()) * sizeof(double));
  if (reads_ && !x->allFinite()) refuse("a number that is not finite");
}

void Archive::pass(Eigen::VectorXd* x) {
  const auto size = static_cast<Eigen::Index>(pass_count(static_cast<std::size_t>(x->size()), sizeof(double)));
  x->resize(size);
  pass_raw(x->data(), static_cast<std::size_t>(x->size()) * sizeof(double));
  if (reads_ && !x->allFinite()) refuse("a number that is not finite");
}

}  // namespace deformable_sim
