#include "client/link/motion_player.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"

namespace handgraft::client {
namespace {

using testing::ElementsAre;

PlayClock::Time at(double time_s) {
  return PlayClock::Time(std::chrono::hours(1)) +
         std::chrono::microseconds(std::llround(1e6 * time_s));
}

TEST(PlayClock, StandsUntilItIsPlayedAndEndsAtTheEnd) {
  PlayClock clock(2.0);
  EXPECT_EQ(clock.at(at(5)), 0.0);
  clock.play(at(5));
  EXPECT_NEAR(clock.at(at(6.5)), 1.5, 1e-9);
  EXPECT_TRUE(clock.isPlaying(at(6.5)));
  EXPECT_EQ(clock.at(at(9)), 2.0);
  EXPECT_FALSE(clock.isPlaying(at(9)));
  clock.play(at(10));
  EXPECT_NEAR(clock.at(at(10.5)), 0.5, 1e-9) << "from the end on it begins anew";
}

TEST(PlayClock, PlaysFromATimeThatIsStillToCome) {
  PlayClock clock(2.0);
  clock.play(at(0.5));
  EXPECT_TRUE(clock.isPlaying(at(0)));
  EXPECT_EQ(clock.at(at(0.25)), 0.0);
  clock.setSpeed(2.0, at(0.25));
  EXPECT_EQ(clock.at(at(0.5)), 0.0) << "it does not set out earlier for that";
  EXPECT_NEAR(clock.at(at(0.75)), 0.5, 1e-9);
  clock.pause(at(0.25));
  EXPECT_FALSE(clock.isPlaying(at(0.75)));
}

TEST(PlayClock, GoesOnFromWhereItWasPaused) {
  PlayClock clock(2.0);
  clock.play(at(0));
  clock.pause(at(0.5));
  EXPECT_NEAR(clock.at(at(7)), 0.5, 1e-9);
  EXPECT_FALSE(clock.isPlaying(at(7)));
  clock.play(at(7));
  EXPECT_NEAR(clock.at(at(7.25)), 0.75, 1e-9);
  clock.play(at(7.25));
  EXPECT_NEAR(clock.at(at(7.5)), 1.0, 1e-9) << "playing already, it changes nothing";
}

TEST(PlayClock, SeeksAndChangesItsSpeedWithoutAJump) {
  PlayClock clock(10.0);
  clock.play(at(0));
  clock.setSpeed(0.5, at(2));
  EXPECT_NEAR(clock.at(at(2)), 2.0, 1e-9);
  EXPECT_NEAR(clock.at(at(4)), 3.0, 1e-9);
  clock.seek(8.0, at(4));
  EXPECT_NEAR(clock.at(at(5)), 8.5, 1e-9);
}

TEST(PlayClock, Loops) {
  PlayClock clock(2.0);
  clock.setLooping(true, at(0));
  clock.play(at(0));
  EXPECT_NEAR(clock.at(at(5)), 1.0, 1e-9);
  EXPECT_TRUE(clock.isPlaying(at(5)));
  clock.setLooping(false, at(5));
  EXPECT_EQ(clock.at(at(7)), 2.0);
}

TEST(PlayClock, SaysWhatIsOutOfRange) {
  PlayClock clock(2.0);
  EXPECT_THROW(clock.seek(2.5, at(0)), InvalidInput);
  EXPECT_THROW(clock.seek(std::nan(""), at(0)), InvalidInput);
  EXPECT_THROW(clock.setSpeed(0, at(0)), InvalidInput);
  EXPECT_THROW(PlayClock(-1.0), InvalidInput);
  // A motion of one frame is at its end at once.
  PlayClock still(0.0);
  still.setLooping(true, at(0));
  still.play(at(0));
  EXPECT_EQ(still.at(at(3)), 0.0);
}

v1::MotionFrame frame(std::uint32_t index, double time_s, const std::vector<double>& joints) {
  v1::MotionFrame made;
  made.index(index);
  made.time_s(time_s);
  made.joint_positions(joints);
  return made;
}

TEST(JointInterpolation, IsLinearBetweenFramesAndStandsBeyondThem) {
  const JointInterpolation way(
      {frame(0, 1.0, {0, 1}), frame(1, 1.5, {1, 3}), frame(2, 2.5, {2, 3})});
  EXPECT_EQ(way.duration(), 1.5);
  EXPECT_THAT(way.at(-1), ElementsAre(0, 1));
  EXPECT_THAT(way.at(0.25), ElementsAre(0.5, 2));
  EXPECT_THAT(way.at(1.0), ElementsAre(1.5, 3));
  EXPECT_THAT(way.at(9), ElementsAre(2, 3));
}

TEST(ChangingWay, GoesOverToAnotherWithinHalfASecond) {
  ChangingWay way(JointInterpolation({frame(0, 0, {0}), frame(1, 2, {2})}));
  way.goOverTo(JointInterpolation({frame(0, 0, {1}), frame(1, 2, {3})}), at(10));
  EXPECT_THAT(way.at(1.0, at(10)), ElementsAre(1));
  EXPECT_THAT(way.at(1.0, at(10.25)), ElementsAre(1.5));
  EXPECT_TRUE(way.isChanging(at(10.25))) << "a third way would make it jump";
  EXPECT_FALSE(way.isChanging(at(10.5)));
  EXPECT_THAT(way.at(1.0, at(10.5)), ElementsAre(2));
  EXPECT_THAT(way.at(2.0, at(99)), ElementsAre(3));
  EXPECT_THROW(way.goOverTo(JointInterpolation({frame(0, 0, {1}), frame(1, 3, {3})}), at(99)),
               InvalidInput);
  EXPECT_THAT(way.at(2.0, at(99)), ElementsAre(3));
}

TEST(JointInterpolation, WantsFramesThatBelongTogether) {
  EXPECT_THROW(JointInterpolation({}), InvalidInput);
  EXPECT_THROW(JointInterpolation({frame(0, 0, {1}), frame(1, 0, {2})}), InvalidInput);
  EXPECT_THROW(JointInterpolation({frame(0, 0, {1}), frame(1, 1, {2, 3})}), InvalidInput);
}

}  // namespace
}  // namespace handgraft::client
