#include "deformable_sim/core/parallel/workers.h"

#include <atomic>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

#include "deformable_sim/core/error.h"
#include "deformable_sim/core/grid/bands.h"
#include "support/four_threads.h"

namespace deformable_sim {
namespace {

class WorkersOf : public testing::TestWithParam<int> {
 protected:
  test::FourThreads allowed_;
  Workers workers_{GetParam()};
  Workers::Shift shift_{&workers_};
};
INSTANTIATE_TEST_SUITE_P(, WorkersOf, testing::Values(1, 2, 3, 4));

TEST_P(WorkersOf, WorkOnEveryPieceOnce) {
  // sum of k = n (n - 1) / 2, and every piece counted once, for loops shorter and longer than there are threads.
  for (int pieces : {0, 1, 2, 3, 5, 1000}) {
    std::vector<std::atomic<int>> visits(static_cast<size_t>(pieces));
    for (auto& v : visits) v = 0;
    std::atomic<int> sum{0};
    workers_.for_each(pieces, [&](int k) {
      ++visits[static_cast<size_t>(k)];
      sum += k;
    });
    for (const auto& v : visits) EXPECT_EQ(v, 1);
    EXPECT_EQ(sum, pieces * (pieces - 1) / 2);
  }
}

TEST_P(WorkersOf, ShareALoopWithinAPiece) {
  // 7 x 11 pieces, each once.
  std::vector<std::atomic<int>> visits(77);
  for (auto& v : visits) v = 0;
  workers_.for_each(7,
                    [&](int i) { workers_.for_each(11, [&](int j) { ++visits[static_cast<size_t>(11 * i + j)]; }); });
  for (const auto& v : visits) EXPECT_EQ(v, 1);
}

TEST_P(WorkersOf, HandAnExceptionToTheCaller) {
  // Thrown by one piece of many, as it is; the next loop is whole again.
  const auto fail = [&] {
    workers_.for_each(100, [](int k) {
      if (k == 37) throw std::runtime_error("piece 37");
    });
  };
  try {
    fail();
    FAIL() << "nothing thrown";
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(), "piece 37");
  }
  std::atomic<int> count{0};
  workers_.for_each(100, [&](int) { ++count; });
  EXPECT_EQ(count, 100);
}

TEST_P(WorkersOf, AddUpBandsInTheirOrder) {
  // 1e16 + 1 + ... + 1 - 1e16 in floating point is another number in every order: that of one thread is asked for.
  const BandLoop bands(Bands::of(96, 96), &workers_), alone(Bands::of(96, 96), nullptr);
  ASSERT_EQ(bands.count(), 12);
  const auto part = [](const RowBand& rows, int) {
    if (rows.first == 0) return 1e16;
    return rows.end == 96 ? -1e16 : 1.0 + rows.first / 1000.0;
  };
  const double sum = alone.sum(part);
  for (int repeat = 0; repeat < 50; ++repeat) EXPECT_EQ(bands.sum(part), sum);
}

TEST(Workers, RefuseANumberThatIsNone) {
  // 1 ... 64.
  for (int threads : {-1, 0, 65}) EXPECT_THROW(Workers{threads}, InputError) << threads;
}

TEST(Workers, AreNoMoreThanTheProgramMayHave) {
  const test::FourThreads allowed;
  EXPECT_EQ(Workers(64).threads(), 4);
}

TEST(Bands, CoverEveryRowOnceAndDependOnTheGridAlone) {
  // first(0) = 0, first(k + 1) = end(k), end(last) = rows; a small sheet is one band.
  for (int rows : {2, 8, 40, 56, 80, 161, 1000}) {
    for (int cols : {2, 60, 400}) {
      const Bands bands = Bands::of(rows, cols);
      EXPECT_EQ(bands.first(0), 0);
      for (int k = 0; k + 1 < bands.count(); ++k) EXPECT_EQ(bands.end(k), bands.first(k + 1));
      EXPECT_EQ(bands.end(bands.count() - 1), rows);
      if (rows * cols < Bands::kLeastNodes) {
        EXPECT_EQ(bands.count(), 1);
      }
    }
  }
}

}  // namespace
}  // namespace deformable_sim
