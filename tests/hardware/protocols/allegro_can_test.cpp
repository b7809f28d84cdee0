// The Allegro Hand's CAN frames, held against frames recorded from a hand by others.

#include "hardware/protocols/allegro_can.h"

#include <gtest/gtest.h>

#include "tests/hardware/protocols/hex.h"

namespace handgraft::protocols::allegro {
namespace {

using handgraft::test::fromHex;
using handgraft::test::toHex;
using handgraft::test::vectorOf;

// candump of a hand under its vendor's driver: torques of all four fingers.
TEST(AllegroCan, TorquesAreTheFramesOfTheVendorsDriver) {
  const std::array<std::pair<std::uint32_t, const char*>, 4> recorded = {
      {{0x180, "02 00 CB 00 42 00 25 00"},
       {0x184, "01 00 B9 00 4A 00 33 00"},
       {0x188, "F1 FF C9 00 38 00 1F 00"},
       {0x18C, "58 02 05 00 8D FF FA FF"}}};
  const std::array<Numbers, 4> pwm = {
      {{2, 203, 66, 37}, {1, 185, 74, 51}, {-15, 201, 56, 31}, {600, 5, -115, -6}}};
  for (std::size_t finger = 0; finger < kFingerCount; ++finger) {
    const CanFrame frame = setTorque(finger, pwm[finger]);
    EXPECT_EQ(frame.id, recorded[finger].first);
    EXPECT_EQ(toHex(vectorOf(frame.bytes())), toHex(fromHex(recorded[finger].second)));
    const auto told = torqueOf(frame);
    ASSERT_TRUE(told.has_value());
    EXPECT_EQ(told->finger, finger);
    EXPECT_EQ(told->numbers, pwm[finger]);
  }
}

TEST(AllegroCan, TemperaturesOfARecordAreRead) {
  CanFrame frame = makeCanFrame(0x0EC, fromHex("30 26 24 F6"));
  const auto told = temperatureOf(frame);
  ASSERT_TRUE(told.has_value());
  EXPECT_EQ(told->finger, 3u);
  EXPECT_EQ(told->numbers, (Numbers{48, 38, 36, 246}));
}

TEST(AllegroCan, CommandsHaveTheirIds) {
  EXPECT_EQ(systemOn().id, 0x40u << 2);
  EXPECT_EQ(systemOff().id, 0x41u << 2);
  EXPECT_EQ(askFor(Command::kFingerPose, 2).id, 0x22u << 2);
  EXPECT_TRUE(askFor(Command::kFingerPose, 2).is_remote);
}

TEST(AllegroCan, OtherFramesAreNone) {
  EXPECT_FALSE(poseOf(setTorque(0, {})));
  EXPECT_FALSE(poseOf(askFor(Command::kFingerPose, 0)));
  EXPECT_FALSE(poseOf(makeCanFrame(idOf(Command::kFingerPose, 0), fromHex("01 02 03"))));
  EXPECT_FALSE(torqueOf(makePose(1, {1, 2, 3, 4})));
  EXPECT_EQ(poseOf(makePose(1, {1, -2, 3, -32768}))->numbers, (Numbers{1, -2, 3, -32768}));
}

}  // namespace
}  // namespace handgraft::protocols::allegro
