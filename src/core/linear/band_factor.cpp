// L D L^T of a band, two lanes at a time.
//
// Column k of a lane holds L of its k-th group: pivot by pivot, the rows from the pivot down to the end of the last
// group it couples with. Right-looking: a group, once eliminated, is subtracted from the columns behind it.
#include "band_factor.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

namespace deformable_sim {
namespace {

using Two = double __attribute__((vector_size(16)));
using TwoFlags = std::int64_t __attribute__((vector_size(16)));
constexpr std::array<double, 9> kNoBlock{};

struct Pair {  // one value of each lane; a class, so that vectors of it keep the alignment
  Two v;
};

/// f(0), f(1) ... f(count - 1), each with its number known to the compiler.
template <class F, int... k>
inline void each(const F& f, std::integer_sequence<int, k...>) {
  (f(std::integral_constant<int, k>()), ...);
}
template <int count, class F>
inline void each(const F& f) {
  each(f, std::make_integer_sequence<int, count>());
}

/// S unknowns a group, groups couple B places far.
template <int S, int B>
class Lanes : public BandFactor {
  static constexpr int kRows = (B + 1) * S;  // that a pivot of a column can reach
  static constexpr int kEntries = S * kRows - S * (S - 1) / 2;
  static constexpr int entry(int pivot, int row) { return pivot * kRows - pivot * (pivot + 1) / 2 + row; }
  static constexpr int kMiddle = (B + 1) * S;  // unknowns there, at most

  /// Where a block of groups (i, j), i at or behind j, lies: point-point, then with a scalar row in i, j and both.
  struct Source {
    int point = -1, row = -1, column = -1, both = -1;
  };

 public:
  Lanes(const BlockMatrix& a, const BandPart& part) : groups_(part.group) {
    const auto n = static_cast<int>(groups_.size());
    length_ = n > B + 1 ? (n - B) / 2 : 0;
    middle_ = n - 2 * length_;
    for (int k = 0; k < length_; ++k) {
      for (int t = 0; t <= B; ++t) {
        source_.push_back({source(a, k + t, k), source(a, n - 1 - k - t, n - 1 - k)});
      }
    }
    for (int i = 0; i < middle_; ++i) {
      for (int j = 0; j <= i; ++j) middle_source_.push_back(source(a, length_ + i, length_ + j));
    }
    column_.resize(static_cast<size_t>(length_ + B) * kEntries);
    rest_.resize(static_cast<size_t>(length_ + B) * S);
  }

  LinearReport solve(const BlockMatrix& a, const Nodes& b, Nodes* x) override {
    lanes_definite_ = TwoFlags{-1, -1};
    definite_ = true;
    clear_meeting();
    if (length_ > 0) eliminate(a, b);
    solve_middle(a, b);
    substitute(x);
    if constexpr (S == 4) {
      keep_unused(a);
      solve_unused(x, b);
    }
    LinearReport report;
    report.definite = definite_ && lanes_definite_[0] != 0 && lanes_definite_[1] != 0;
    if (!report.definite) report.solved = keep_finite(x);
    return report;
  }

  void solve_again(const Nodes& b, Nodes* x) override {
    for (int k = 0; k < length_; ++k) load_rest(b, k, rest(k));
    for (size_t k = static_cast<size_t>(length_) * S; k < rest_.size(); ++k) rest_[k].v = Two{0.0, 0.0};
    for (int k = 0; k < length_; ++k) {
      const Two* c = column(k);
      Two* z = rest(k);
      each<S>([&](auto p) { each<kRows - 1 - p>([&](auto i) { z[p + 1 + i] -= c[entry(p, p + 1 + i)] * z[p]; }); });
    }
    for (int i = 0; i < middle_; ++i) {
      for (int p = 0; p < S; ++p) dense_rest_[S * i + p] = right_side(b, static_cast<size_t>(length_ + i), p);
    }
    if (length_ > 0) add_lanes_to_rest();
    for (int j = 0; j < middle_ * S; ++j) {
      for (int i = j + 1; i < middle_ * S; ++i) dense_rest_[i] -= dense_[i][j] / dense_[j][j] * dense_rest_[j];
    }
    substitute_middle();
    substitute(x);
    if constexpr (S == 4) solve_unused(x, b);
  }

 private:
  Source source(const BlockMatrix& a, int i, int j) const {
    const auto& row = groups_[static_cast<size_t>(i)];
    const auto& column = groups_[static_cast<size_t>(j)];
    const auto slot = [&](int p, int q) { return p < 0 || q < 0 ? -1 : a.slot(p, q); };
    return {slot(row[0], column[0]), slot(row[1], column[0]), slot(row[0], column[1]), slot(row[1], column[1])};
  }

  static const double* block(const BlockMatrix& a, int slot) {
    return slot < 0 ? kNoBlock.data() : a.block(slot).data();
  }

  /// Entry (i, j) of a block of groups.
  struct Block {
    const double *point, *row = nullptr, *column = nullptr, *both = nullptr;
    double missing;
    Block(const BlockMatrix& a, const Source& s, bool diagonal) : point(block(a, s.point)) {
      if constexpr (S == 4) {
        row = block(a, s.row);
        column = block(a, s.column);
        both = block(a, s.both);
        missing = diagonal && s.both < 0 ? 1.0 : 0.0;  // a group without a scalar row
      }
    }
    double operator()(int i, int j) const {
      if (i < 3 && j < 3) return point[3 * j + i];
      if (j < 3) return row[3 * j];
      if (i < 3) return column[i];
      return both[0] + missing;
    }
  };

  void load_column(const BlockMatrix& a, int k, Two* c) const {
    const std::array<Source, 2>* source = source_.data() + static_cast<std::ptrdiff_t>(k) * (B + 1);
    const Block first(a, source[0][0], true), second(a, source[0][1], true);
    each<S>([&](auto j) { each<S - j>([&](auto i) { c[entry(j, j + i)] = Two{first(j + i, j), second(j + i, j)}; }); });
    for (int t = 1; t <= B; ++t) {
      const Block one(a, source[t][0], false), other(a, source[t][1], false);
      each<S>([&](auto j) {
        Two* at = c + entry(j, S * t);
        each<S>([&](auto i) { at[i] = Two{one(i, j), other(i, j)}; });
      });
    }
  }

  double right_side(const Nodes& b, size_t group, int i) const {
    if (S == 3 || i < 3) return b(i, groups_[group][0]);
    return groups_[group][1] < 0 ? 0.0 : b(0, groups_[group][1]);
  }

  void load_rest(const Nodes& b, int k, Two* z) const {
    const auto one = static_cast<size_t>(k), other = groups_.size() - 1 - static_cast<size_t>(k);
    each<S>([&](auto i) { z[i] = Two{right_side(b, one, i), right_side(b, other, i)}; });
  }

  /// The columns behind the lanes gather what the lanes leave of the middle.
  void clear_meeting() {
    for (size_t k = static_cast<size_t>(length_) * kEntries; k < column_.size(); ++k) column_[k].v = Two{0.0, 0.0};
    for (size_t k = static_cast<size_t>(length_) * S; k < rest_.size(); ++k) rest_[k].v = Two{0.0, 0.0};
  }

  void eliminate(const BlockMatrix& a, const Nodes& b) {
    for (int k = 0; k < B && k < length_; ++k) load(a, b, k);
    for (int k = 0; k < length_; ++k) {
      if (k + B < length_) load(a, b, k + B);
      step(column(k), rest(k));
    }
  }

  void load(const BlockMatrix& a, const Nodes& b, int k) {
    load_column(a, k, column(k));
    load_rest(b, k, rest(k));
  }

  /// Eliminates the group of column c; z is its right side.
  void step(Two* c, Two* z) {
    Two left[S][kRows];  // L D
    each<S>([&](auto p) {
      const Two pivot = c[entry(p, p)];
      lanes_definite_ &= pivot > 0.0;
      const Two inverse = 1.0 / pivot;
      c[entry(p, p)] = inverse;
      each<kRows - 1 - p>([&](auto i) {
        constexpr int row = p + 1 + i;
        left[p][row] = c[entry(p, row)];
        c[entry(p, row)] *= inverse;
      });
      each<S - 1 - p>([&](auto q) {
        constexpr int next = p + 1 + q;
        const Two factor = c[entry(p, next)];
        each<kRows - next>([&](auto i) { c[entry(next, next + i)] -= factor * left[p][next + i]; });
        z[next] -= factor * z[p];
      });
    });
    each<B>([&](auto t) {
      Two* behind = c + (t + 1) * kEntries;
      each<S>([&](auto q) {
        constexpr int row = (t + 1) * S + q;
        each<kRows - row>([&](auto i) {
          Two sum = c[entry(0, row)] * left[0][row + i];
          each<S - 1>([&](auto p) { sum += c[entry(p + 1, row)] * left[p + 1][row + i]; });
          behind[entry(q, q + i)] -= sum;
        });
        Two sum = c[entry(0, row)] * z[0];
        each<S - 1>([&](auto p) { sum += c[entry(p + 1, row)] * z[p + 1]; });
        z[row] -= sum;
      });
    });
  }

  /// Dense, lower part only: what the matrix has there and what the lanes have left.
  void solve_middle(const BlockMatrix& a, const Nodes& b) {
    const int n = middle_ * S;
    const Source* source = middle_source_.data();
    for (int i = 0; i < middle_; ++i) {
      for (int j = 0; j <= i; ++j) {
        const Block values(a, *source++, i == j);
        for (int p = 0; p < S; ++p) {
          for (int q = 0; q < S; ++q) dense_[S * i + p][S * j + q] = values(p, q);
        }
      }
      for (int p = 0; p < S; ++p) dense_rest_[S * i + p] = right_side(b, static_cast<size_t>(length_ + i), p);
    }
    if (length_ > 0) {
      add_lanes();
      add_lanes_to_rest();
    }
    for (int j = 0; j < n; ++j) {
      definite_ = definite_ && dense_[j][j] > 0.0;
      const double inverse = 1.0 / dense_[j][j];
      for (int i = j + 1; i < n; ++i) {
        const double factor = dense_[i][j] * inverse;
        for (int k = j + 1; k <= i; ++k) dense_[i][k] -= factor * dense_[k][j];
        dense_rest_[i] -= factor * dense_rest_[j];
      }
    }
    substitute_middle();
  }

  void substitute_middle() {
    for (int j = middle_ * S - 1; j >= 0; --j) {
      double sum = dense_rest_[j];
      for (int i = j + 1; i < middle_ * S; ++i) sum -= dense_[i][j] * dense_rest_[i];
      dense_rest_[j] = sum / dense_[j][j];
    }
    for (int k = 0; k < B && length_ > 0; ++k) {
      for (int p = 0; p < S; ++p)
        rest(length_ + k)[p] = Two{dense_rest_[S * k + p], dense_rest_[S * (middle_ - 1 - k) + p]};
    }
  }

  void add_lanes() {
    for (int k = 0; k < B; ++k) {
      const Two* c = column(length_ + k);
      for (int q = 0; q < S; ++q) {
        for (int i = q; i < (B - k) * S; ++i) {
          const Two value = c[entry(q, i)];
          dense_[S * k + i][S * k + q] += value[0];
          // The other lane counts groups from the far end.
          const int row = S * (middle_ - 1 - k - i / S) + i % S, column = S * (middle_ - 1 - k) + q;
          dense_[std::max(row, column)][std::min(row, column)] += value[1];
        }
      }
    }
  }

  void add_lanes_to_rest() {
    for (int k = 0; k < B; ++k) {
      const Two* z = rest(length_ + k);
      for (int q = 0; q < S; ++q) {
        dense_rest_[S * k + q] += z[q][0];
        dense_rest_[S * (middle_ - 1 - k) + q] += z[q][1];
      }
    }
  }

  void store(double value, size_t group, int i, Nodes* x) const {
    if (S == 3 || i < 3) {
      (*x)(i, groups_[group][0]) = value;
    } else if (groups_[group][1] >= 0) {
      (*x)(0, groups_[group][1]) = value;
    }
  }

  /// Backwards. What is known longest comes first: a sum waits for its last term alone.
  void substitute(Nodes* x) {
    for (int k = 0; k < middle_; ++k) {
      for (int p = 0; p < S; ++p) store(dense_rest_[S * k + p], static_cast<size_t>(length_ + k), p, x);
    }
    for (int k = length_ - 1; k >= 0; --k) {
      const Two* c = column(k);
      Two* z = rest(k);
      each<S>([&](auto j) {
        constexpr int p = S - 1 - j;
        Two sum = z[p] * c[entry(p, p)];
        each<kRows - 1 - p>([&](auto i) { sum -= c[entry(p, kRows - 1 - i)] * z[kRows - 1 - i]; });
        z[p] = sum;
        store(sum[0], static_cast<size_t>(k), p, x);
        store(sum[1], groups_.size() - 1 - static_cast<size_t>(k), p, x);
      });
    }
  }

  /// y and z of rows of one unknown.
  void keep_unused(const BlockMatrix& a) {
    unused_.resize(groups_.size());
    for (size_t k = 0; k < groups_.size(); ++k) {
      if (groups_[k][1] < 0) continue;
      const Mat3& block = a.block(a.diagonal_slot(groups_[k][1]));
      unused_[k] = {block(1, 1), block(2, 2)};
    }
  }
  void solve_unused(Nodes* x, const Nodes& b) const {
    for (size_t k = 0; k < groups_.size(); ++k) {
      const int row = groups_[k][1];
      if (row < 0) continue;
      (*x)(1, row) = b(1, row) / unused_[k][0];
      (*x)(2, row) = b(2, row) / unused_[k][1];
    }
  }

  bool keep_finite(Nodes* x) const {
    bool finite = true;
    for (const auto& group : groups_) {
      for (int node : group) finite = finite && (node < 0 || x->col(node).allFinite());
    }
    if (finite) return true;
    for (const auto& group : groups_) {
      for (int node : group) {
        if (node >= 0) x->col(node).setZero();
      }
    }
    return false;
  }

  Two* column(int k) { return &column_[static_cast<size_t>(k) * kEntries].v; }
  Two* rest(int k) { return &rest_[static_cast<size_t>(k) * S].v; }

  std::vector<std::array<int, 2>> groups_;
  int length_ = 0, middle_ = 0;                // groups of a lane, and between the two
  std::vector<std::array<Source, 2>> source_;  // B + 1 a column
  std::vector<Source> middle_source_;          // lower part, by rows
  std::vector<Pair> column_, rest_;            // of length_ groups, then B for what is left to the middle
  std::vector<std::array<double, 2>> unused_;  // diagonal in y and z of rows of one unknown
  double dense_[kMiddle][kMiddle], dense_rest_[kMiddle];
  TwoFlags lanes_definite_{-1, -1};
  bool definite_ = true;
};

}  // namespace

std::unique_ptr<BandFactor> make_band_factor(const BlockMatrix& pattern, const BandPart& part) {
  if (part.has_scalars) {
    if (part.bandwidth <= 2) return std::make_unique<Lanes<4, 2>>(pattern, part);
    if (part.bandwidth <= 4) return std::make_unique<Lanes<4, 4>>(pattern, part);
    return std::make_unique<Lanes<4, kWidestBand>>(pattern, part);
  }
  if (part.bandwidth <= 1) return std::make_unique<Lanes<3, 1>>(pattern, part);
  if (part.bandwidth <= 2) return std::make_unique<Lanes<3, 2>>(pattern, part);
  if (part.bandwidth <= 4) return std::make_unique<Lanes<3, 4>>(pattern, part);
  return std::make_unique<Lanes<3, kWidestBand>>(pattern, part);
}

}  // namespace deformable_sim
