// Lists of messages are believed as far as their bytes go.
#include "deformable_sim/ros/careful_messages.h"

#include <gtest/gtest.h>

#include "deformable_sim/ros/messages.h"

namespace deformable_sim {
namespace {

msg::Obstacle obstacle() {
  msg::Obstacle message;
  message.name = "a";
  message.primitives.resize(2);
  message.primitives[1].dimensions = {1.0, 2.0};
  message.primitive_poses.resize(2);
  message.primitive_poses[0].position.x = 3.0;
  message.planes.resize(1);
  message.planes[0].coef[3] = 4.0;
  message.octomaps.resize(1);
  message.octomaps[0].data = {1, -2, 3};
  message.lets_through = {"b", "c"};
  return message;
}

std::vector<std::uint8_t> bytes_of(const msg::Obstacle& message) {
  std::vector<std::uint8_t> bytes(ros::serialization::serializationLength(message));
  ros::serialization::OStream stream(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  ros::serialization::serialize(stream, message);
  return bytes;
}

TEST(CarefulMessages, ReadWhatWasWritten) {
  std::vector<std::uint8_t> bytes = bytes_of(obstacle());
  const auto read = read_carefully<msg::Obstacle>(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  EXPECT_EQ(bytes, bytes_of(*read));
}

TEST(CarefulMessages, CutAnywhereAreDropped) {
  const std::vector<std::uint8_t> whole = bytes_of(obstacle());
  for (std::size_t size = 0; size < whole.size(); ++size) {
    std::vector<std::uint8_t> bytes(whole.begin(), whole.begin() + static_cast<long>(size));
    EXPECT_THROW(read_carefully<msg::Obstacle>(bytes.data(), static_cast<std::uint32_t>(size)),
                 ros::serialization::StreamOverrunException);
  }
}

// A count of 2^32 - 1 in each four bytes in turn: what is made room for stays below a few times the bytes there are.
TEST(CarefulMessages, CountsBeyondTheBytesAreRefused) {
  const std::vector<std::uint8_t> whole = bytes_of(obstacle());
  for (std::size_t at = 0; at + 4 <= whole.size(); ++at) {
    std::vector<std::uint8_t> bytes = whole;
    std::fill_n(bytes.begin() + static_cast<long>(at), 4, std::uint8_t{0xff});
    try {
      const auto read = read_carefully<msg::Obstacle>(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
      EXPECT_LE(read->primitives.size() + read->meshes.size() + read->planes.size(), bytes.size());
    } catch (const ros::serialization::StreamOverrunException&) {
    }
  }
}

}  // namespace
}  // namespace deformable_sim
