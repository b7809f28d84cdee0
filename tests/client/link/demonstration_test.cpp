#include "client/link/demonstration.h"

#include <fstream>
#include <vector>

#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/shared_data.h"

namespace handgraft::client {
namespace {

using testing::AllOf;
using testing::HasSubstr;

/// Of one frame; `fields` come before the others.
Demonstration demonstrationWith(const std::string& fields) {
  const auto path = test::scratchDirectory() / "demonstration.json";
  std::ofstream file(path);
  file << "{\"format\": \"handgraft-demonstration/1\", " << fields
       << "\"time_s\": [0.0], \"object_pose\": [[0, 0, 0, 1, 0, 0, 0]], \"joints_W_m\": [[";
  for (int joint = 0; joint < 21; ++joint)
    file << (joint == 0 ? "" : ", ") << "[0, 0, " << 0.01 * joint << "]";
  file << "]]}";
  file.close();
  return readDemonstration(path);
}

v1::SessionState sessionOn(const std::string& object) {
  v1::SessionState session;
  session.session_id(3);
  session.object(object);
  return session;
}

TEST(Demonstration, AnotherObjectThanTheSessionsIsToldWithBothNames) {
  const Demonstration of_lemon = demonstrationWith("\"object\": \"lemon\", ");
  EXPECT_EQ(of_lemon.frames.size(), 1U);
  EXPECT_THAT(noteOfAnotherObject(of_lemon, sessionOn("box")),
              AllOf(HasSubstr("object 'lemon'"), HasSubstr("session 3 holds 'box'")));
  EXPECT_EQ(noteOfAnotherObject(of_lemon, sessionOn("lemon")), "");
}

TEST(Demonstration, AModelThatWasSentIsCalledAsItsFileIs) {
  const Demonstration of_mug = demonstrationWith("\"object\": \"mug\", ");
  EXPECT_EQ(noteOfAnotherObject(of_mug, sessionOn("mug-0123abcd")), "");
}

TEST(Demonstration, TheOtherSideOfTheHandThatFollowsIsTold) {
  v1::HandDescription hand;
  const Demonstration left = demonstrationWith("\"side\": \"left\", ");
  EXPECT_EQ(noteOfTheOtherSide(left, hand), "") << "nobody knows the hand's";
  hand.chirality(v1::CHIRALITY_RIGHT);
  EXPECT_THAT(noteOfTheOtherSide(left, hand),
              HasSubstr("a left hand touched, and this is a right one"));
  EXPECT_EQ(noteOfTheOtherSide(demonstrationWith("\"side\": \"right\", "), hand), "");
}

TEST(Demonstration, OneThatNamesNoObjectIsOfAny) {
  EXPECT_EQ(noteOfAnotherObject(demonstrationWith(""), sessionOn("box")), "");
}

TEST(Demonstration, TellsFramesThatTheTrackerLost) {
  const auto path = test::scratchDirectory() / "lost.json";
  const std::string zero = fmt::format("[{}]", fmt::join(std::vector<int>(48, 0), ","));
  std::ofstream(path) << "{\"format\":\"handgraft-demonstration/1\",\"time_s\":[0,0.5],"
                         "\"object_pose\":[[0,0,0,1,0,0,0]],\"mano_pose_rad\":["
                      << zero << "," << zero << "],\"mano_translation_m\":[[0,0,NaN],[0,0,0]]}";
  const Demonstration read = readDemonstration(path);
  EXPECT_EQ(read.frames.size(), 1U);
  EXPECT_THAT(read.notes, testing::ElementsAre(HasSubstr("left out 1 of 2 frames")));
}

}  // namespace
}  // namespace handgraft::client
