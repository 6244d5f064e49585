// Requests are done once, in order, or not at all.
#include "deformable_sim/ros/request_queue.h"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

namespace deformable_sim {
namespace {

constexpr double kLong = 20.0;  // s, only ever reached by a failure

Reply note(const std::string& text) {
  Reply reply;
  reply.note = text;
  return reply;
}

TEST(RequestQueue, DoesWhatArrivedInOrder) {
  // Invariant: order of arrival is order of doing.
  RequestQueue queue;
  std::vector<int> done;
  for (int i = 0; i < 5; ++i) {
    queue.post(
        [&done, i] {
          done.push_back(i);
          return Reply();
        },
        [](const Reply&) {});
  }
  EXPECT_TRUE(queue.run());
  EXPECT_EQ(done, (std::vector<int>{0, 1, 2, 3, 4}));
  EXPECT_FALSE(queue.run());
}

TEST(RequestQueue, ACallReturnsTheReplyOfItsJob) {
  RequestQueue queue;
  Reply reply;
  std::thread caller([&] { reply = queue.call([] { return note("done"); }, kLong); });
  while (!queue.run()) queue.wait(kLong);
  caller.join();
  EXPECT_TRUE(reply.status.ok());
  EXPECT_EQ(reply.note, "done");
}

TEST(RequestQueue, ACallThatTimedOutIsNeverDone) {
  // Invariant: an answer of kTimeout means "not applied", also later.
  RequestQueue queue;
  bool done = false;
  const Reply reply = queue.call(
      [&] {
        done = true;
        return Reply();
      },
      0.0);
  EXPECT_EQ(reply.status.code, Code::kTimeout);
  queue.run();
  EXPECT_FALSE(done);
}

TEST(RequestQueue, ARefusalThrownByAJobIsItsReply) {
  RequestQueue queue;
  std::vector<Code> codes;
  const Done keep = [&](const Reply& reply) { codes.push_back(reply.status.code); };
  queue.post([]() -> Reply { throw InputError("no", Code::kOutOfRange); }, keep);
  queue.post([]() -> Reply { throw std::runtime_error("trouble"); }, keep);
  queue.run();
  EXPECT_EQ(codes, (std::vector<Code>{Code::kOutOfRange, Code::kInternal}));
}

TEST(RequestQueue, AFloodIsRefusedAndDoesNotStopTime) {
  // Invariant: run() ends, whatever its jobs post; more than 1000 waiting are refused.
  RequestQueue queue;
  int refused = 0;
  const Done count = [&](const Reply& reply) { refused += reply.status.code == Code::kUnavailable; };
  std::function<Reply()> again = [&] {
    queue.post(again, count);
    return Reply();
  };
  for (int i = 0; i < 1001; ++i) queue.post(again, count);
  EXPECT_EQ(refused, 1);
  EXPECT_TRUE(queue.run());
}

TEST(RequestQueue, ClosingAnswersEverybody) {
  RequestQueue queue;
  Reply waiting;
  std::thread caller([&] { waiting = queue.call([] { return Reply(); }, kLong); });
  queue.wait(kLong);
  queue.close();
  caller.join();
  EXPECT_EQ(waiting.status.code, Code::kUnavailable);
  EXPECT_EQ(queue.call([] { return Reply(); }, kLong).status.code, Code::kUnavailable);
}

}  // namespace
}  // namespace deformable_sim
