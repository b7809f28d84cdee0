#include <algorithm>
#include <cmath>
#include <fstream>
#include <random>
#include <sstream>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "hardware/config/device_section.h"
#include "hardware/config/hand_config_file.h"
#include "hardware/safety/governor.h"

#include "tests/hardware/config/config_texts.h"

namespace handgraft::config {
namespace {

namespace fs = std::filesystem;
using texts::contains;
using texts::example_configs;
using texts::examplePath;
using texts::exampleText;
using texts::kSmall;
using texts::objectionTo;
using texts::smallWith;

// === Examples

TEST(HandConfig, EveryExampleIsSound) {
  for (const std::string& name : example_configs) {
    const HandConfig config = readHandConfig(examplePath(name));
    EXPECT_EQ(config.motors.size(), makeMotorMap(config)->motorCount());
    const safety::Governor governor(config.governor);
    EXPECT_EQ(governor.state(), safety::GovernorState::kDisconnected);
  }
}

TEST(HandConfig, EveryExampleMeasuresThePoseThatItPromised) {
  std::mt19937 random(1);
  for (const std::string& name : example_configs) {
    const HandConfig config = readHandConfig(examplePath(name));
    const std::unique_ptr<tendon::MotorMap> map = makeMotorMap(config);
    std::vector<double> q(config.jointCount()), residual(q.size()), measured(q.size());
    std::vector<double> motors(map->motorCount());
    for (int trial = 0; trial < 100; ++trial) {
      for (std::size_t j = 0; j < q.size(); ++j) {
        const safety::JointLimits& limits = config.governor.limits[j];
        q[j] = std::uniform_real_distribution<double>(limits.lower, limits.upper)(random);
      }
      map->command(q, motors, residual);
      map->measure(motors, measured);
      for (std::size_t j = 0; j < q.size(); ++j)
        EXPECT_NEAR(measured[j], q[j] - residual[j], 1e-9) << name << " joint " << j;
      for (std::size_t i = 0; i < motors.size(); ++i) {
        EXPECT_GE(motors[i], config.motors[i].range_rad.lower - 1e-9);
        EXPECT_LE(motors[i], config.motors[i].range_rad.upper + 1e-9);
      }
    }
  }
}

TEST(HandConfig, ReadsWhatIsThere) {
  const HandConfig config = readHandConfig(examplePath("printed_tendon_hand"));
  EXPECT_EQ(config.hand, "printed_tendon_hand");
  EXPECT_EQ(config.device.kind, DeviceKind::kODrive);
  EXPECT_EQ(config.device.carrier, CanCarrier::kSlcan);
  EXPECT_EQ(config.device.firmware, ODriveFirmware::k06);
  EXPECT_EQ(config.governor.period_s, 0.01);
  EXPECT_EQ(config.governor.brake_within.count(), 500);
  ASSERT_EQ(config.jointCount(), 11u);
  EXPECT_EQ(config.governor.names[2], "index_mcp");
  EXPECT_EQ(config.governor.limits[2].upper, 1.4);
  EXPECT_EQ(config.governor.limits[2].jerk, 500);
  const tendon::TendonHand& hand = config.transmission.tendons;
  ASSERT_EQ(hand.tendons.size(), 3u);
  EXPECT_EQ(hand.tendons[1].crossings[1].extension.at(0).slope, 0.007);
  EXPECT_EQ(hand.tendons[2].spool.growth_m, 0.0004);
  EXPECT_EQ(hand.joints[3].rest, 0.05);
  EXPECT_EQ(config.motors[2].direction, -1);
  ASSERT_EQ(config.homing.size(), 3u);
  EXPECT_EQ(config.homing[2].motor, 2u);
  EXPECT_EQ(config.homing[0].hold.count(), 300);
}

TEST(HandConfig, RemarksOnAnglesInDegrees) {
  EXPECT_EQ(remarksOn(parseHandConfig(kSmall)), std::vector<std::string>{});
  std::string text = kSmall;
  for (std::size_t at = text.find("upper_rad: 1.5"); at != std::string::npos;
       at = text.find("upper_rad: 1.5", at + 1))
    text.replace(at, 14, "upper_rad: 90 ");
  const std::vector<std::string> told = remarksOn(parseHandConfig(text));
  ASSERT_EQ(told.size(), 2U);
  EXPECT_TRUE(contains(told[0], "joint 'a': 0 to 90 rad are more than 1 turn")) << told[0];
  EXPECT_TRUE(contains(told[1], "motor 'm'")) << told[1];
  EXPECT_TRUE(contains(told[1], "radians, not degrees")) << told[1];
  for (const std::string& name : example_configs)
    EXPECT_EQ(remarksOn(readHandConfig(examplePath(name))), std::vector<std::string>{}) << name;
}

TEST(HandConfig, ReadsEmergencyStopsOfBothKinds) {
  EXPECT_EQ(parseHandConfig(kSmall).governor.stop_mode, safety::StopMode::kBrake);
  const HandConfig cut = parseHandConfig(std::string(kSmall) + "emergency_stop: {mode: cut}\n");
  EXPECT_EQ(cut.governor.stop_mode, safety::StopMode::kCut);
}

// === Single rules

TEST(HandConfig, TellsAllProblemsAtOnceEachWithItsRange) {
  const std::string text = smallWith("lower_rad: -0.5", "lower_rad: hello");
  std::string worse = text;
  worse.replace(worse.find("kind: simulated"), 15, "kind: magic");
  const std::string objection = objectionTo(worse + "loop: {rate_hz: 5000}\n");
  EXPECT_TRUE(contains(objection, "joints[1].lower_rad: 'hello' is no number")) << objection;
  EXPECT_TRUE(contains(objection, "loop.rate_hz: 5000 is not in [10, 1000]")) << objection;
  EXPECT_TRUE(contains(objection, "device.kind: 'magic' is not one of simulated, dynamixel"))
      << objection;
}

TEST(HandConfig, TellsWhatIsWrongAsAWholeBesideSingleValues) {
  std::string text = exampleText("leap");
  text.replace(text.find("id: 3,"), 6, "id: 2,");
  const std::size_t last = text.rfind("lower_rad: ");
  text.replace(last, text.find(',', last) - last, "lower_rad: 0.9");
  const std::string objection = objectionTo(text + "watch: {silent_ms: soon}\n");
  EXPECT_TRUE(contains(objection, "watch.silent_ms: 'soon' is no whole number")) << objection;
  EXPECT_TRUE(contains(objection, "motors[3].id: 2 is there twice")) << objection;
  EXPECT_TRUE(contains(objection, "motors[15].lower_rad, upper_rad: [0.9,")) << objection;
}

// What stands in for a wrong value must not be found wrong in turn.
TEST(HandConfig, TellsNothingThatFollowsFromAnotherProblem) {
  std::string text = exampleText("leap");
  text.replace(text.find("id: 3,"), 6, "id: x,");
  EXPECT_EQ(objectionTo(text), "motors[3].id: 'x' is no whole number; permitted: 0 to 252");
  const std::string limit =
      objectionTo(smallWith("lower_rad: 0, upper_rad: 1.5}", "lower_rad: 0, upper_rad: up}"));
  EXPECT_TRUE(contains(limit, "joints[0].upper_rad: 'up' is no number")) << limit;
  EXPECT_FALSE(contains(limit, "motors")) << limit;
}

TEST(HandConfig, OfAnUnknownKindOnlyTheKindIsWrong) {
  std::string text = exampleText("leap");
  text.replace(text.find("kind: dynamixel"), 15, "kind: servo");
  EXPECT_EQ(objectionTo(text),
            "device.kind: 'servo' is not one of simulated, dynamixel, ability_hand, odrive, "
            "inspire, allegro");
  text.replace(text.find("baud:"), 5, "bauds:");
  EXPECT_TRUE(contains(objectionTo(text), "device.bauds: unknown key")) << "of any kind";
  text = exampleText("printed_tendon_hand");
  text.replace(text.find("kind: tendons"), 13, "kind: strings");
  EXPECT_EQ(objectionTo(text),
            "transmission.kind: 'strings' is not one of direct, synergies, tendons");
}

TEST(HandConfig, NamesWhatIsMissing) {
  EXPECT_TRUE(contains(objectionTo(smallWith("hand: small", "")), "hand: is missing"));
  EXPECT_TRUE(contains(objectionTo(""), "must be a map"));
  EXPECT_TRUE(contains(objectionTo("format: handgraft-hardware/1"), "device: is missing"));
}

TEST(HandConfig, NamesKeysThatAreThereTwice) {
  EXPECT_TRUE(
      contains(objectionTo(std::string(kSmall) + "hand: other\n"), "hand: is there twice"));
}

TEST(HandConfig, WantsMotorsThatCanGoWhereJointsMay) {
  const std::string objection = objectionTo(smallWith(
      "{name: m, lower_rad: 0, upper_rad: 1.5", "{name: m, lower_rad: 0, upper_rad: 1.4"));
  EXPECT_TRUE(contains(objection,
                       "motors[0].lower_rad, upper_rad: [0, 1.4] does not hold the "
                       "[0, 1.5]"))
      << objection;
}

TEST(HandConfig, WantsMotorsThatAreAsFastAsJointsMayBe) {
  const std::string objection = objectionTo(
      smallWith("upper_rad: 1.5, velocity_rad_s: 2", "upper_rad: 1.5, velocity_rad_s: 1"));
  EXPECT_TRUE(contains(objection, "motors[0].velocity_rad_s: 1 is less than the 2"))
      << objection;
}

TEST(HandConfig, WantsAMotorForEachDirectJoint) {
  const std::string objection = objectionTo(
      smallWith("  - {name: n, lower_rad: -0.5, upper_rad: 1, velocity_rad_s: 2}\n", ""));
  EXPECT_TRUE(contains(objection, "motors: 1 of them, where the transmission needs 2"))
      << objection;
}

TEST(HandConfig, WantsJointsThatCanBrakeInTime) {
  const std::string objection =
      objectionTo(std::string(kSmall) + "emergency_stop: {brake_ms: 50}\n");
  EXPECT_TRUE(contains(objection, "joint 'a': needs")) << objection;
}

TEST(HandConfig, WantsGapsShorterThanTheDevicesDeadman) {
  const std::string objection =
      objectionTo(std::string(kSmall) + "loop: {longest_gap_ms: 150}\n");
  EXPECT_TRUE(
      contains(objection, "loop.longest_gap_ms: 150 is more than the device's watchdog"))
      << objection;
  const std::string slow =
      objectionTo(smallWith("kind: simulated", "kind: simulated, watchdog_ms: 20"));
  EXPECT_TRUE(contains(slow, "device.watchdog_ms: 20 is less than three periods")) << slow;
}

TEST(HandConfig, WantsIdsOfTheDeviceOnce) {
  std::string text = exampleText("leap");
  text.replace(text.find("id: 3,"), 6, "id: 2,");
  EXPECT_TRUE(contains(objectionTo(text), "motors[3].id: 2 is there twice"))
      << objectionTo(text);
}

TEST(HandConfig, KnowsTheAbilityHandsOwnDeadman) {
  std::string text = exampleText("ability_hand");
  text.replace(text.find("watchdog_ms: 300"), 16, "watchdog_ms: 200");
  EXPECT_TRUE(
      contains(objectionTo(text), "device.watchdog_ms: 200; that of an ability_hand is"));
}

TEST(HandConfig, ReadsFollowers) {
  const HandConfig config = parseHandConfig(
      smallWith("  - {name: n, lower_rad: -0.5, upper_rad: 1, velocity_rad_s: 2}\n", "") +
      "transmission: {kind: direct, followers: [{joint: b, leader: a, ratio: 0.5}]}\n");
  const std::unique_ptr<tendon::MotorMap> map = makeMotorMap(config);
  std::vector<double> motors(1), residual(2);
  map->command(std::vector{0.8, 0.0}, motors, residual);
  EXPECT_NEAR(motors[0], 0.8, 1e-15);
  EXPECT_NEAR(residual[1], -0.4, 1e-15);
}

TEST(HandConfig, ReadsJointsThatSlide) {
  const HandConfig config = readHandConfig(examplePath("printed_gripper"));
  ASSERT_EQ(config.jointCount(), 2u);
  for (const safety::JointLimits& limits : config.governor.limits) {
    EXPECT_TRUE(limits.slides);
    EXPECT_EQ(limits.upper, 0.036);
    EXPECT_EQ(limits.velocity, 0.04);
    EXPECT_DOUBLE_EQ(limits.margin, 1e-6);
    EXPECT_EQ(limits.travel, 0.012) << "of the follower, by the motor of its leader";
  }
  const std::unique_ptr<tendon::MotorMap> map = makeMotorMap(config);
  std::vector<double> motors(1), residual(2);
  map->command(std::vector{0.018, 0.018}, motors, residual);
  EXPECT_NEAR(motors[0], 1.5, 1e-12);
  EXPECT_NEAR(residual[1], 0.0, 1e-12);
}

TEST(HandConfig, TellsWhatIsWrongWithJointsThatSlide) {
  const std::string gripper = exampleText("printed_gripper");
  const auto objection = [&gripper](const std::string& old_text, const std::string& new_text) {
    std::string text = gripper;
    text.replace(text.find(old_text), old_text.size(), new_text);
    return objectionTo(text);
  };
  const std::string untold = objection(", travel_m_rad: 0.012", "");
  EXPECT_TRUE(contains(untold, "joints[0].travel_m_rad: is missing: by so many metres"))
      << untold;
  EXPECT_FALSE(contains(untold, ";")) << "nothing that follows from it: " << untold;
  const std::string of_follower =
      objection("right_jaw, lower_m: 0, upper_m: 0.036",
                "right_jaw, lower_m: 0, upper_m: 0.036, travel_m_rad: 0.01");
  EXPECT_TRUE(contains(of_follower, "joints[1].travel_m_rad: 'right_jaw' follows 'left_jaw'"))
      << of_follower;
  const std::string turned = objection("right_jaw, lower_m: 0", "right_jaw, lower_rad: 0");
  EXPECT_TRUE(contains(turned, "joints[1].lower_m: is missing")) << turned;
  EXPECT_TRUE(contains(turned, "joints[1].lower_rad")) << turned;
  const std::string longer = objection("travel_m_rad: 0.012", "travel_m_rad: 0.006");
  EXPECT_TRUE(contains(longer, "does not hold the [0, 6]")) << longer;
  const std::string far =
      objection("lower_m: 0, upper_m: 0.036, travel", "lower_m: 0, upper_m: 36, travel");
  EXPECT_TRUE(contains(far, "joints[0].upper_m: 36 is not in [-10, 10]")) << far;
  std::string text = gripper.substr(0, gripper.find("transmission:"));
  text += "transmission: {kind: synergies, rest_rad: [0, 0], synergies: [{column: [1, 1]}]}\n" +
          gripper.substr(gripper.find("motors:"));
  const std::string coupled = objectionTo(text);
  EXPECT_TRUE(contains(coupled, "transmission.kind: joint 'left_jaw' slides")) << coupled;
}

TEST(HandConfig, RemarksOnLengthsInMillimetres) {
  std::string text = exampleText("printed_gripper");
  const auto replace = [&text](const std::string& old_text, const std::string& new_text) {
    text.replace(text.find(old_text), old_text.size(), new_text);
  };
  replace("upper_m: 0.036", "upper_m: 3.6");
  replace("upper_rad: 3,", "upper_rad: 300,");
  const std::vector<std::string> told = remarksOn(parseHandConfig(text));
  ASSERT_EQ(told.size(), 1U);
  EXPECT_TRUE(contains(told[0], "joint 'left_jaw': 0 to 3.6 m are more than 0.5 m")) << told[0];
}

TEST(HandConfig, ReadsSynergies) {
  std::string text =
      smallWith("  - {name: n, lower_rad: -0.5, upper_rad: 1, velocity_rad_s: 2}\n", "");
  text += "transmission: {kind: synergies, rest_rad: [0, 0], synergies: [{column: [1, 1]}]}\n";
  const HandConfig config = parseHandConfig(text);
  const std::unique_ptr<tendon::MotorMap> map = makeMotorMap(config);
  std::vector<double> motors(1), residual(2);
  map->command(std::vector{0.8, 0.4}, motors, residual);
  EXPECT_NEAR(motors[0], 0.6, 1e-15);
}

TEST(HandConfig, NamesJointsThatDoNotExist) {
  const std::string objection = objectionTo(
      std::string(kSmall) +
      "transmission: {kind: direct, followers: [{joint: c, leader: a, ratio: 0.5}]}\n");
  EXPECT_TRUE(contains(objection, "transmission.followers[0].joint: no joint is named 'c'"))
      << objection;
}

TEST(HandConfig, TellsWhatIsWrongWithTendons) {
  std::string text = exampleText("printed_tendon_hand");
  text.replace(text.find("largest_tension_N: 70"), 21, "largest_tension_N: 7 ");
  EXPECT_TRUE(
      contains(objectionTo(text), "transmission: tendon 'index_flexor': 7 N pull it in"))
      << objectionTo(text);
}

TEST(HandConfig, HomesOnlyWithinWhatAMotorMay) {
  std::string text = exampleText("printed_tendon_hand");
  text.replace(text.find("current_A: 0.3, hold"), 14, "current_A: 9.3");
  EXPECT_TRUE(contains(objectionTo(text), "homing[0].current_A: 9.3 must be less than the 8"))
      << objectionTo(text);
  text = exampleText("printed_tendon_hand");
  text.replace(text.find("{motor: thumb"), 13, "{motor: tump ");
  EXPECT_TRUE(contains(objectionTo(text), "homing[0].motor: no motor is named 'tump'"));
}

TEST(HandConfig, MotorsGoByTheirJointWhateverTheirOrder) {
  const std::string told = smallWith(
      "motors:\n  - {name: m, lower_rad: 0, upper_rad: 1.5, velocity_rad_s: 2}\n  - {name: n,",
      "motors:\n  - {name: n, joint: b, lower_rad: -0.5, upper_rad: 1, velocity_rad_s: 2}\n  - "
      "{name: m, joint: a, lower_rad: 0, upper_rad: 1.5, velocity_rad_s: 2}\n# ");
  const HandConfig config = parseHandConfig(told);
  ASSERT_EQ(config.motors.size(), 2u);
  EXPECT_EQ(config.motors[0].name, "m");
  EXPECT_EQ(config.motors[1].name, "n");
  EXPECT_EQ(config.motors[1].range_rad.lower, -0.5);
  EXPECT_TRUE(contains(objectionTo(smallWith("{name: m,", "{name: m, joint: a,")),
                       "motors[1].joint: is missing: other motors have one"));
  EXPECT_TRUE(contains(objectionTo(smallWith("{name: m,", "{name: m, joint: c,")),
                       "motors[0].joint: 'c' is no joint with a motor of its own: a, b"));
}

TEST(HandConfig, AMotorNamedAsAJointInAnotherPlaceIsRefused) {
  std::string text = smallWith("{name: m,", "{name: b,");
  EXPECT_TRUE(contains(objectionTo(text), "motors[0]: 'b' would move joint 'a'"))
      << objectionTo(text);
}

TEST(HandConfig, AnotherPortOfACanBusIsAnAdapterOrAnInterfaceByItsName) {
  const auto examples = test::sourceDirectory() / "hardware" / "config" / "examples";
  DeviceConfig allegro = readHandConfig(examples / "allegro.yaml").device;
  usePort(allegro, "/dev/ttyACM0");
  EXPECT_EQ(allegro.carrier, CanCarrier::kSlcan);
  EXPECT_EQ(allegro.baud, 115'200);
  usePort(allegro, "can1");
  EXPECT_EQ(allegro.carrier, CanCarrier::kSocketCan);
  EXPECT_EQ(allegro.port, "can1");
  DeviceConfig simulated;
  EXPECT_THROW(usePort(simulated, "/dev/ttyACM0"), InvalidInput);
  EXPECT_THROW(usePort(allegro, ""), InvalidInput);
}

TEST(HandConfig, RefusesAPositionLoopOfOursThatIsTooSlow) {
  const auto path =
      test::sourceDirectory() / "hardware" / "config" / "examples" / "allegro.yaml";
  std::string text = readText(path);
  text.replace(text.find("rate_hz: 333"), 12, "rate_hz: 50");
  EXPECT_TRUE(contains(objectionTo(text), "loop.rate_hz: 50; the position loop"));
}

TEST(HandConfig, RefusesAWireThatIsTooSlowForItsLoop) {
  std::string text = exampleText("leap");
  const auto at = text.find("baud: 4000000");
  text.replace(at, 13, "baud: 57600");
  // 30 + 400 + 94 bytes of ten bits: 91 ms.
  const std::string objection = objectionTo(text);
  EXPECT_TRUE(contains(objection, "device.baud: at 57600 a cycle of 16 motors takes 91 ms"))
      << objection;
  EXPECT_TRUE(contains(objection, "at most 8 Hz")) << objection;
  text.replace(text.find("baud: 57600"), 11, "baud: 1000000");
  EXPECT_EQ(objectionTo(text), "") << "5.2 ms of 10";
}

TEST(HandConfig, ReadsGainsAndTorqueConstantsOfDynamixels) {
  std::string text = exampleText("leap");
  const std::string motor = "joint: \"0\", id: 0,";
  text.replace(text.find(motor), motor.size(),
               motor + " gains: {p: 600, d: 200}, torque_Nm_A: 0.36,");
  const HandConfig config = parseHandConfig(text);
  ASSERT_TRUE(config.motors[0].gains.has_value());
  EXPECT_EQ(config.motors[0].gains->p, 600);
  EXPECT_EQ(config.motors[0].gains->i, 0);
  EXPECT_EQ(config.motors[0].gains->d, 200);
  EXPECT_EQ(config.motors[0].torque_Nm_A, 0.36);
  EXPECT_FALSE(config.motors[1].gains.has_value());
}

TEST(HandConfig, MotorsThatAreHomedAreIncrementalUnlessTheySayOtherwise) {
  const HandConfig tendons = parseHandConfig(exampleText("printed_tendon_hand"));
  for (const MotorConfig& motor : tendons.motors)
    EXPECT_EQ(motor.encoder, Encoder::kIncremental);
  for (const MotorConfig& motor : parseHandConfig(exampleText("leap")).motors)
    EXPECT_EQ(motor.encoder, Encoder::kAbsolute);
  std::string text = exampleText("leap");
  text.replace(text.find("id: 0,"), 6, "id: 0, encoder: incremental,");
  EXPECT_TRUE(contains(objectionTo(text), "motors[0].encoder: an incremental one needs a step"))
      << objectionTo(text);
}

TEST(HandConfig, NamesTheFileThatIsWrong) {
  const fs::path path = test::scratchDirectory() / "wrong.yaml";
  std::ofstream(path) << "format: [";
  try {
    readHandConfig(path);
    FAIL() << "accepted";
  } catch (const InvalidInput& error) {
    EXPECT_TRUE(contains(error.what(), "wrong.yaml")) << error.what();
    EXPECT_TRUE(contains(error.what(), "line 1")) << error.what();
  }
  EXPECT_THROW(readHandConfig("/nonexistent/hand.yaml"), InvalidInput);
}

}  // namespace
}  // namespace handgraft::config
