// A config that is made reads as it is, whatever the hand: it is what a newcomer begins with.

#include "hardware/bringup/make_config.h"

#include <fstream>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "hardware/config/hand_config_file.h"

#include "tests/support/shared_data.h"

namespace handgraft::bringup {
namespace {

/// `joints` that turn, and one more that follows the first.
std::filesystem::path urdfOf(std::size_t joints) {
  std::string text = "<robot name=\"made\"><link name=\"palm\"/>";
  const auto add = [&](const std::string& name, const std::string& more) {
    text += fmt::format(
        "<link name=\"l_{0}\"/><joint name=\"{0}\" type=\"revolute\"><parent link=\"palm\"/>"
        "<child link=\"l_{0}\"/><limit lower=\"-0.5\" upper=\"1.5\" effort=\"1\" "
        "velocity=\"5\"/>{1}</joint>",
        name, more);
  };
  for (std::size_t i = 0; i < joints; ++i)
    add(fmt::format("j{}", i), "");
  add("follower", "<mimic joint=\"j0\" multiplier=\"1\"/>");
  const auto path = test::scratchDirectory() / "made.urdf";
  std::ofstream(path) << text + "</robot>\n";
  return path;
}

config::HandConfig made(std::size_t joints, const ConfigPlan& plan) {
  return config::parseHandConfig(makeConfig(urdfOf(joints), plan));
}

TEST(MakeConfig, OfEachKindReadsAsItIs) {
  for (const char* kind : {"dynamixel", "ability_hand", "odrive", "simulated"}) {
    ConfigPlan plan;
    plan.kind = kind;
    const config::HandConfig config = made(6, plan);
    EXPECT_EQ(config.motors.size(), 6u) << kind;
    EXPECT_EQ(config.jointCount(), 7u) << kind;
    EXPECT_NEAR(1 / config.governor.period_s, plan.kind == "dynamixel" ? 21 : 50, 1e-9) << kind;
  }
}

TEST(MakeConfig, RunsAsFastAsItsWirePermitsAndNoFaster) {
  for (std::size_t joints = 1; joints < 20; ++joints) {
    for (const int baud : {57'600, 115'200, 1'000'000}) {
      ConfigPlan plan;
      plan.baud = baud;
      try {
        const config::HandConfig config = made(joints, plan);
        const double rate_Hz = 1 / config.governor.period_s;
        EXPECT_LE(rate_Hz, 50 + 1e-9);
        // One more a second would be refused.
        std::string text = makeConfig(urdfOf(joints), plan);
        const std::string told = fmt::format("rate_hz: {:.0f}", rate_Hz);
        ASSERT_NE(text.find(told), std::string::npos);
        text.replace(text.find(told), told.size(), fmt::format("rate_hz: {:.0f}", rate_Hz + 1));
        if (rate_Hz < 49.5) {
          EXPECT_THROW(config::parseHandConfig(text), InvalidInput) << text;
        }
      } catch (const InvalidInput& error) {
        EXPECT_NE(std::string(error.what()).find("--baud"), std::string::npos) << error.what();
        EXPECT_GT(joints, 12u) << error.what();
        EXPECT_EQ(baud, 57'600) << error.what();
      }
    }
  }
}

TEST(MakeConfig, SaysWhatIsNoModelOfAHand) {
  EXPECT_THROW(makeConfig(test::scratchDirectory() / "nothing.urdf", {}), InvalidInput);
  const auto path = test::scratchDirectory() / "stiff.urdf";
  std::ofstream(path) << "<robot name=\"stiff\"><link name=\"palm\"/></robot>";
  EXPECT_THROW(makeConfig(path, {}), InvalidInput);
}

}  // namespace
}  // namespace handgraft::bringup
