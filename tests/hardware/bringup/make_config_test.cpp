// A config that is made reads as it is, whatever the hand: it is what a newcomer begins with.

#include "hardware/bringup/make_config.h"

#include <array>
#include <fstream>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "hardware/config/hand_config_file.h"

#include "tests/hardware/bringup/accepted_config.h"
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
  return config::parseHandConfig(test::acceptedConfig(makeConfig(urdfOf(joints), plan)));
}

ConfigPlan ofKind(const std::string& kind) {
  ConfigPlan plan;
  plan.kind = kind;
  return plan;
}

TEST(MakeConfig, OfEachKindReadsAsItIs) {
  for (const config::DeviceTraits& traits : config::deviceKinds()) {
    ConfigPlan plan;
    plan.kind = traits.name;
    const std::size_t joints =
        traits.own_motors > 0 ? static_cast<std::size_t>(traits.own_motors) : 6;
    const config::HandConfig config = made(joints, plan);
    EXPECT_EQ(config.motors.size(), joints) << traits.name;
    EXPECT_EQ(config.jointCount(), joints + 1) << traits.name;
    const double rate = !traits.has_own_loop                            ? 333
                        : traits.kind == config::DeviceKind::kDynamixel ? 21
                                                                        : 50;
    EXPECT_NEAR(1 / config.governor.period_s, rate, 1e-9) << traits.name;
  }
}

TEST(MakeConfig, LeavesItToTheOwnerToAcceptThatNothingStopsTheMotors) {
  for (const config::DeviceTraits& traits : config::deviceKinds()) {
    if (traits.has_watchdog) continue;
    const auto joints = static_cast<std::size_t>(traits.own_motors);
    const std::string text = makeConfig(urdfOf(joints), ofKind(traits.name));
    EXPECT_NE(text.find("no_watchdog: FILL IN"), std::string::npos) << text;
    try {
      config::parseHandConfig(text);
      ADD_FAILURE() << traits.name;
    } catch (const InvalidInput& error) {
      const std::string told = error.what();
      EXPECT_NE(told.find("device.no_watchdog: "), std::string::npos) << told;
      EXPECT_NE(told.find("its motors go on turning"), std::string::npos) << told;
      EXPECT_NE(told.find("`no_watchdog: accepted`"), std::string::npos) << told;
    }
    EXPECT_NO_THROW(config::parseHandConfig(test::acceptedConfig(text))) << traits.name;
  }
}

TEST(MakeConfig, OfAWholeHandHasAllOfItsMotorsAndNoOthers) {
  for (const char* kind : {"ability_hand", "inspire", "allegro"}) {
    ConfigPlan plan;
    plan.kind = kind;
    try {
      made(5, plan);
      ADD_FAILURE() << kind;
    } catch (const InvalidInput& error) {
      EXPECT_NE(std::string(error.what()).find("5 of its joints move by themselves"),
                std::string::npos)
          << error.what();
    }
  }
}

TEST(MakeConfig, GivesMotorsTheIdsThatAreToldAndCountsOn) {
  ConfigPlan plan;
  plan.kind = "inspire";
  plan.ids = {5, 4, 3, 2, 1, 0};
  const config::HandConfig inspire = made(6, plan);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(inspire.motors[i].id, static_cast<int>(5 - i));
    EXPECT_EQ(inspire.motors[i].direction, -1);
  }
  plan.kind = "dynamixel";
  plan.ids = {7, 3};
  const config::HandConfig dynamixel = made(4, plan);
  const std::array<int, 4> ids = {7, 3, 4, 5};
  for (std::size_t i = 0; i < ids.size(); ++i)
    EXPECT_EQ(dynamixel.motors[i].id, ids[i]);
  for (const std::vector<int>& wrong :
       {std::vector<int>{3, 3}, {-1}, {253}, {1, 2, 3, 4, 5}, {252}}) {
    plan.ids = wrong;
    EXPECT_THROW(made(4, plan), InvalidInput) << wrong.front();
  }
}

TEST(MakeConfig, TakesABusByItsInterfaceOrItsAdapter) {
  for (const char* kind : {"odrive", "allegro"}) {
    ConfigPlan plan;
    plan.kind = kind;
    plan.port = "can0";
    plan.can_bitrate = 1'000'000;
    const config::HandConfig interface = made(16, plan);
    EXPECT_EQ(interface.device.carrier, config::CanCarrier::kSocketCan) << kind;
    EXPECT_EQ(interface.device.can_bitrate, 1'000'000) << kind;
    plan.port = "/dev/ttyACM0";
    EXPECT_EQ(made(16, plan).device.carrier, config::CanCarrier::kSlcan) << kind;
  }
}

TEST(MakeConfig, SaysThatATorqueLoopNeedsAFasterBus) {
  ConfigPlan plan;
  plan.kind = "allegro";
  plan.can_bitrate = 100'000;
  try {
    made(16, plan);
    ADD_FAILURE();
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("--can-bitrate"), std::string::npos)
        << error.what();
  }
}

TEST(MakeConfig, OfAHandThatWeHave) {
  ConfigPlan plan;
  plan.kind = "allegro";
  const auto hands = test::sourceDirectory() / "server" / "models" / "hands";
  const config::HandConfig config = config::parseHandConfig(
      test::acceptedConfig(makeConfig(hands / "allegro16" / "allegro16.urdf", plan)));
  EXPECT_EQ(config.motors.size(), 16u);
  plan.kind = "dynamixel";
  plan.baud = 1'000'000;
  for (const char* name : {"allegro16", "barrett8", "human20", "tendon16"}) {
    const auto urdf = hands / name / (std::string(name) + ".urdf");
    EXPECT_NO_THROW(config::parseHandConfig(makeConfig(urdf, plan))) << name;
  }
}

TEST(MakeConfig, LeadersGoAsFarAsTheirFollowersCan) {
  const auto path = test::scratchDirectory() / "led.urdf";
  std::ofstream(path) << "<robot name='led'>"
                         "<joint name='j' type='revolute'>"
                         "<limit lower='-0.6' upper='1.5' velocity='1' effort='1'/></joint>"
                         "<joint name='k' type='revolute'>"
                         "<limit lower='-0.3' upper='9' velocity='1' effort='1'/>"
                         "<mimic joint='j' multiplier='0.75' offset='0'/></joint>"
                         "<joint name='l' type='revolute'>"
                         "<limit lower='-0.15' upper='9' velocity='1' effort='1'/>"
                         "<mimic joint='k' multiplier='1' offset='0'/></joint></robot>";
  const config::HandConfig config =
      config::parseHandConfig(makeConfig(path, ofKind("simulated")));
  ASSERT_EQ(config.motors.size(), 1u);
  EXPECT_NEAR(config.governor.limits.front().lower, -0.2, 1e-12);
  EXPECT_NEAR(config.governor.limits.front().upper, 1.5, 1e-12);
}

TEST(MakeConfig, OfASimulatedHandAsksForNoCalibration) {
  EXPECT_TRUE(made(2, ofKind("simulated")).calibration.empty());
  EXPECT_FALSE(made(2, ofKind("dynamixel")).calibration.empty());
}

TEST(MakeConfig, NamesTheHandAsAServerDoesThatReadsTheFile) {
  const auto path = test::scratchDirectory() / "allegro hand_right.urdf";
  std::filesystem::copy_file(urdfOf(2), path,
                             std::filesystem::copy_options::overwrite_existing);
  const config::HandConfig config =
      config::parseHandConfig(makeConfig(path, ofKind("simulated")));
  EXPECT_EQ(config.hand, "allegro_hand_right") << "its <robot> is called 'made'";
}

TEST(MakeConfig, SaysWhichKindsThereAre) {
  ConfigPlan plan;
  plan.kind = "servo";
  try {
    made(2, plan);
    ADD_FAILURE();
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("inspire, allegro"), std::string::npos)
        << error.what();
  }
}

TEST(MakeConfig, RunsAsFastAsItsWirePermitsAndNoFaster) {
  for (std::size_t joints = 1; joints < 20; ++joints) {
    for (const int baud : {57'600, 115'200, 1'000'000}) {
      ConfigPlan plan;
      plan.baud = baud;
      try {
        const config::HandConfig config = made(joints, plan);
        const double rate = 1 / config.governor.period_s;
        EXPECT_LE(rate, 50 + 1e-9);
        // One more a second would be refused.
        std::string text = makeConfig(urdfOf(joints), plan);
        const std::string told = fmt::format("rate_hz: {:.0f}", rate);
        ASSERT_NE(text.find(told), std::string::npos);
        text.replace(text.find(told), told.size(), fmt::format("rate_hz: {:.0f}", rate + 1));
        if (rate < 49.5) {
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

TEST(MakeConfig, OfAGripperGivesMetresToJawsThatSlide) {
  const auto path = test::scratchDirectory() / "gripper.urdf";
  const auto jaw = [](const char* name, const char* more) {
    return fmt::format(
        "<link name=\"l_{0}\"/><joint name=\"{0}\" type=\"prismatic\"><parent link=\"palm\"/>"
        "<child link=\"l_{0}\"/><limit lower=\"0\" upper=\"0.04\" effort=\"9\" "
        "velocity=\"0.1\"/>{1}</joint>",
        name, more);
  };
  std::ofstream(path) << "<robot name=\"gripper\"><link name=\"palm\"/>" << jaw("left", "")
                      << jaw("right", "<mimic joint=\"left\" multiplier=\"1\"/>")
                      << "</robot>\n";
  const std::string text = makeConfig(path, {});
  EXPECT_NE(text.find("FILL IN travel_m_rad"), std::string::npos) << text;
  const config::HandConfig config = config::parseHandConfig(text);
  ASSERT_EQ(config.jointCount(), 2u);
  for (const safety::JointLimits& limits : config.governor.limits) {
    EXPECT_TRUE(limits.slides);
    EXPECT_EQ(limits.upper, 0.04);
    EXPECT_EQ(limits.travel, 0.01);
  }
  ASSERT_EQ(config.motors.size(), 1u) << "one draws both";
  EXPECT_EQ(config.motors[0].range_rad.upper, 4.0);
  EXPECT_THROW(makeConfig(path, ofKind("inspire")), InvalidInput);
}

TEST(MakeConfig, SaysWhatIsNoModelOfAHand) {
  EXPECT_THROW(makeConfig(test::scratchDirectory() / "nothing.urdf", {}), InvalidInput);
  const auto path = test::scratchDirectory() / "stiff.urdf";
  std::ofstream(path) << "<robot name=\"stiff\"><link name=\"palm\"/></robot>";
  EXPECT_THROW(makeConfig(path, {}), InvalidInput);
}

}  // namespace
}  // namespace handgraft::bringup
