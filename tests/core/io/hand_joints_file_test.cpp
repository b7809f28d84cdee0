#include "core/io/hand_joints_file.h"

#include <fstream>
#include <string>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"

#include "tests/support/shared_data.h"

namespace handgraft::io {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

std::filesystem::path write(const std::string& text) {
  const auto path = test::scratchDirectory() / "joints.json";
  std::ofstream(path) << text;
  return path;
}

/// Joint i at (i + offset, 0.5, -1).
std::string joints(int count, double offset = 0.0) {
  std::string text;
  for (int i = 0; i < count; ++i)
    text += fmt::format("{}[{}, 0.5, -1]", i > 0 ? "," : "", i + offset);
  return "[" + text + "]";
}

TEST(HandJointsFile, GivesTheOtherHandsToo) {
  const std::string two =
      fmt::format(R"({{"hands":[{{"joints":{},"valid":true}},{{"joints":{},"valid":true}},)"
                  R"({{"joints":[],"valid":false}}]}})",
                  joints(21), joints(21, 100.0));
  const HandsOfFile hands = readHands(write(two), 1);
  EXPECT_EQ(hands.joints.p_O(0, 3), 103.0);
  ASSERT_EQ(hands.others.size(), 1u) << "the one that is not valid is none";
  EXPECT_EQ(hands.others[0].p_O(0, 3), 3.0);
  EXPECT_TRUE(readHands(write(joints(21))).others.empty());
}

void expectFault(const std::string& text, const char* fault) {
  const auto path = write(text);
  EXPECT_THAT(
      [&] {
        readHandJoints(path);
      },
      ThrowsMessage<InvalidInput>(HasSubstr(fault)))
      << text;
}

TEST(HandJointsFile, ReadsAListBareOrNamed) {
  for (const std::string& text : {joints(21), "{\"joints\": " + joints(21) + "}"}) {
    const contact::HandJoints read = readHandJoints(write(text));
    EXPECT_EQ(read.p_O.col(20), Eigen::Vector3d(20, 0.5, -1)) << text;
  }
}

TEST(HandJointsFile, TakesTheValidHand) {
  const auto two = [](const char* left, const char* right) {
    return write(fmt::format(
        R"({{"hands": [{{"valid": {}, "joints": {}}}, {{"valid": {}, "joints": {}}}]}})", left,
        joints(21), right, joints(21, 100)));
  };
  EXPECT_EQ(readHandJoints(two("false", "true")).p_O(0, 0), 100.0);
  EXPECT_EQ(readHandJoints(two("true", "false")).p_O(0, 0), 0.0);
  const auto both = two("true", "true");
  EXPECT_THAT(
      [&] {
        readHandJoints(both);
      },
      ThrowsMessage<InvalidInput>(HasSubstr("2 valid hands: 0, 1")));
  EXPECT_EQ(readHandJoints(both, 1).p_O(0, 0), 100.0);
  const auto left = two("true", "false");
  EXPECT_THROW(readHandJoints(left, 1), InvalidInput);
  EXPECT_THROW(readHandJoints(left, 2), InvalidInput);
  EXPECT_THROW(readHandJoints(two("false", "false")), InvalidInput);
}

TEST(HandJointsFile, NamesWhatIsWrong) {
  expectFault(joints(20), "20 items; a list of 21");
  expectFault("{\"joints\": 3}", "no list");
  expectFault("{\"places\": []}", "neither of the fields");
  expectFault("3", "neither");
  expectFault("[[0,0,0]", "joints.json");
  std::string text = joints(21);
  expectFault(text.replace(text.find("0.5"), 3, "\"a\""), "joint 0 is no [x, y, z]");
  text = joints(21);
  expectFault(text.replace(text.find(", -1"), 4, ""), "joint 0 is no [x, y, z]");
}

}  // namespace
}  // namespace handgraft::io
