// The bridge as a process with real time, DDS and a tty between it and an emulated device.

#include <algorithm>
#include <atomic>
#include <cmath>
#include <csignal>
#include <fstream>
#include <set>
#include <thread>

#include <gtest/gtest.h>

#include "tests/support/environment_variable.h"
#include "tests/support/shared_data.h"
#include "tests/support/test_domain.h"
#include "tests/system/bridge_bench.h"
#include "tests/system/live_session.h"

namespace handgraft::test {
namespace {

const std::vector<std::string> three_joints{"a", "b", "c"};

// === A session's solutions move each device

/// Looks, from the side, at what a device decodes and at what the bridge says that it commands:
/// joints by direct drive, so that the first ones are the motors'.
class FrameWatch {
 public:
  explicit FrameWatch(BridgeBench& bench)
      : bench_(bench), looker_([this] {
          look();
        }) {}

  ~FrameWatch() { end(); }

  void expectDecodedIsCommanded() {
    end();
    ASSERT_FALSE(told_.empty());
    EXPECT_TRUE(isSame(goals(), told_.back()))
        << "at rest, what was told last is what it holds";
    // A busy machine may miss telling a period, or looking at it.
    const auto found = std::count_if(decoded_.begin(), decoded_.end(), [&](const auto& goals) {
      return std::any_of(told_.begin(), told_.end(), [&](const auto& command) {
        return isSame(goals, command);
      });
    });
    EXPECT_GE(found, 10) << "of " << decoded_.size() << " decoded and " << told_.size()
                         << " told";
    EXPECT_GE(found, static_cast<long>(decoded_.size() / 2));
  }

 private:
  void look() {
    while (!is_ending_) {
      if (bench_.rig().isPowered()) decoded_.insert(goals());
      for (const v1::JointState& state : bench_.jointStates()) {
        if (state.state() == v1::BRIDGE_ARMED) told_.push_back(state.command());
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  }

  void end() {
    is_ending_ = true;
    if (looker_.joinable()) looker_.join();
  }

  std::vector<double> goals() {
    const std::size_t motors = bench_.config().motors.size();
    std::vector<double> all;
    for (std::size_t i = 0; i < motors; ++i)
      all.push_back(bench_.rig().goal(i));
    return all;
  }

  // Within one of the device's units.
  bool isSame(const std::vector<double>& goals, const std::vector<double>& command) {
    for (std::size_t i = 0; i < goals.size(); ++i) {
      if (std::abs(goals[i] - command[i]) > bench_.rig().unit(i)) return false;
    }
    return true;
  }

  BridgeBench& bench_;
  std::set<std::vector<double>> decoded_;
  std::vector<std::vector<double>> told_;
  std::atomic<bool> is_ending_{false};
  std::thread looker_;
};

class SessionOnADevice : public testing::TestWithParam<std::string> {};

TEST_P(SessionOnADevice, SolutionsMoveTheMotors) {
  const Service service;
  LiveSession session(service, "barrett8", "lemon", "lemon_6");
  const std::vector<std::string>& joints = session.opened().joint_names();
  const double limit = 2.6;  // as far as an Ability Hand counts
  BridgeBench bench(service.network(), directConfig(GetParam(), "barrett8", joints, limit));
  bench.startBridge();
  FrameWatch frames(bench);
  const v1::PoseSolution solved = session.optimize();
  std::vector<double> wanted;
  for (std::size_t i = 0; i < bench.config().motors.size(); ++i)
    wanted.push_back(std::clamp(solved.joint_positions()[i], -limit, limit));
  ASSERT_TRUE(bench.arm()) << bench.told();
  EXPECT_TRUE(bench.arrive(
      [&] {
        return wanted;
      },
      2e-3))
      << bench.told();
  const auto status = bench.status(v1::BRIDGE_ARMED);
  ASSERT_TRUE(status.has_value()) << bench.told();
  EXPECT_EQ(status->session_id(), session.id());
  EXPECT_EQ(status->hand(), "barrett8");
  frames.expectDecodedIsCommanded();
  // A seventh and eighth joint follow others where there are six motors: what is left is told.
  double left = 0;
  for (std::size_t i = wanted.size(); i < joints.size(); ++i)
    left = std::max(left, std::abs(solved.joint_positions()[i] - wanted[i - wanted.size()]));
  EXPECT_NEAR(status->residual_rad(), left, 1e-2);
}

INSTANTIATE_TEST_SUITE_P(Devices,
                         SessionOnADevice,
                         testing::Values("dynamixel", "ability_hand", "odrive"),
                         [](const auto& told) {
                           return told.param;
                         });

// === A gripper whose jaws slide

constexpr const char* kGripperUrdf = R"(<robot name="printed_gripper">
  <link name="base"><visual><origin xyz="0 0 0.03"/><geometry><box size="0.05 0.11 0.06"/></geometry></visual></link>
  <link name="left"><visual><origin xyz="0 0.006 0.04"/><geometry><box size="0.022 0.012 0.08"/></geometry></visual></link>
  <link name="right"><visual><origin xyz="0 -0.006 0.04"/><geometry><box size="0.022 0.012 0.08"/></geometry></visual></link>
  <joint name="left_jaw" type="prismatic"><parent link="base"/><child link="left"/><origin xyz="0 0 0.06"/>
    <axis xyz="0 1 0"/><limit lower="0" upper="0.036" effort="10" velocity="0.1"/></joint>
  <joint name="right_jaw" type="prismatic"><parent link="base"/><child link="right"/><origin xyz="0 0 0.06"/>
    <axis xyz="0 -1 0"/><limit lower="0" upper="0.036" effort="10" velocity="0.1"/>
    <mimic joint="left_jaw"/></joint>
</robot>)";

class GripperOnADevice : public testing::Test {
 protected:
  GripperOnADevice() {
    const auto path = scratchDirectory() / "printed_gripper.urdf";
    std::ofstream(path) << kGripperUrdf;
    const Finished loaded = service.client({"load", "hand", path.string()});
    EXPECT_EQ(loaded.exit_code, 0) << loaded.err;
  }

  // Before the service: its skin is made once for both tests.
  EnvironmentVariable cache{"XDG_CACHE_HOME", scratchDirectory() / "cache"};
  Service service;
};

TEST_F(GripperOnADevice, MetresOfASolutionTurnItsMotor) {
  LiveSession session(service, "printed_gripper", "box", "box_5");
  BridgeBench bench(service.network(), patientExample("printed_gripper"));
  bench.startBridge();
  const v1::PoseSolution solved = session.optimize();
  ASSERT_EQ(solved.joint_positions().size(), 1u) << "of the jaw that leads";
  const double jaw_m = solved.joint_positions()[0];
  ASSERT_GT(jaw_m, 0.002) << "the box is between the jaws";
  ASSERT_TRUE(bench.arm()) << bench.told();
  EXPECT_TRUE(bench.arrive(
      [&] {
        return std::vector<double>{jaw_m / 0.012};
      },
      3e-3))
      << bench.told();
}

TEST_F(GripperOnADevice, WhoseJawTurnsInItsConfigIsNotArmed) {
  LiveSession session(service, "printed_gripper", "box", "box_5");
  std::string config = patientExample("printed_gripper");
  for (const char* key : {"lower", "upper"}) {
    for (int jaw = 0; jaw < 2; ++jaw) {
      const std::string metres = std::string(key) + "_m: ";
      config.replace(config.find(metres), metres.size(), std::string(key) + "_rad: ");
    }
  }
  replace(config, ", travel_m_rad: 0.012", "");
  replace(config, "motion: {velocity_m_s: 0.04, acceleration_m_s2: 0.4, jerk_m_s3: 12}",
          "motion: {velocity_rad_s: 0.04, acceleration_rad_s2: 0.4, jerk_rad_s3: 12}");
  BridgeBench bench(service.network(), config);
  bench.startBridge();
  session.optimize();
  ASSERT_TRUE(bench.status([](const v1::BridgeStatus& status) {
    return !status.warnings().empty() && status.poses_accepted() > 0;
  })) << bench.told();
  bench.command(v1::COMMAND_ARM);
  const auto refused = bench.status([](const v1::BridgeStatus& status) {
    return status.refusal() != v1::REFUSAL_NONE;
  });
  ASSERT_TRUE(refused.has_value()) << bench.told();
  EXPECT_EQ(refused->last_refusal(),
            "ARM refused: joint 'left_jaw' turns in the config and slides in its model; joint "
            "'right_jaw' turns in the config and slides in its model");
  EXPECT_EQ(refused->refusal(), v1::REFUSAL_OTHER_JOINTS);
  EXPECT_FALSE(bench.rig().isPowered());
}

// === What must end motion, on a Dynamixel hand of three motors

class BridgeOnADevice : public testing::Test {
 protected:
  /// Armed, and on its way to a pose that is seconds away.
  void moveOn() {
    bench.startBridge();
    server->stream({0.0, 0.0, 0.0});
    ASSERT_TRUE(bench.arm()) << bench.told();
    server->stream({2.4, -2.4, 2.4});
    ASSERT_TRUE(bench.status([](const v1::BridgeStatus& status) {
      return status.state() == v1::BRIDGE_ARMED && status.poses_accepted() > 1;
    })) << bench.told();
  }

  std::vector<double> angles() {
    return {bench.rig().angle(0), bench.rig().angle(1), bench.rig().angle(2)};
  }

  /// False if motors are under power after 20 s still.
  bool goesOff() {
    for (int i = 0; i < 200 && bench.rig().isPowered(); ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    return !bench.rig().isPowered();
  }

  void expectStandsStill() {
    const std::vector<double> before = angles();
    std::this_thread::sleep_for(std::chrono::milliseconds(700));
    EXPECT_EQ(angles(), before) << bench.told();
  }

  TestDomain domain;
  Network network{domain.number(), "lo"};
  BridgeBench bench{network, directConfig("dynamixel", "three", three_joints, 2.5)};
  std::unique_ptr<StandInServer> server =
      std::make_unique<StandInServer>(network, "three", three_joints);
};

TEST_F(BridgeOnADevice, KilledTheDevicesOwnWatchdogStopsTheMotors) {
  moveOn();
  bench.bridge().send(SIGKILL);
  EXPECT_EQ(bench.bridge().wait(), 128 + SIGKILL);
  EXPECT_TRUE(goesOff());
  expectStandsStill();
}

TEST_F(BridgeOnADevice, SuspendedItIsAFaultWhenItGoesOn) {
  moveOn();
  bench.bridge().send(SIGSTOP);
  std::this_thread::sleep_for(std::chrono::seconds(3));
  EXPECT_FALSE(bench.rig().isPowered()) << "the device waits for 2.5 s";
  bench.bridge().send(SIGCONT);
  const auto status = bench.status(v1::BRIDGE_FAULT);
  ASSERT_TRUE(status.has_value()) << bench.told();
  EXPECT_TRUE(goesOff());
  server->stream({0.1, 0.1, 0.1});
  expectStandsStill();
}

TEST_F(BridgeOnADevice, ASignalStopsItForGood) {
  moveOn();
  bench.bridge().send(SIGUSR1);
  const auto status = bench.status(v1::BRIDGE_ESTOP);
  ASSERT_TRUE(status.has_value()) << bench.told();
  EXPECT_TRUE(goesOff());
  server->stream({0.1, 0.1, 0.1});
  bench.command(v1::COMMAND_ARM);
  expectStandsStill();
  bench.command(v1::COMMAND_RESET);
  EXPECT_TRUE(bench.status(v1::BRIDGE_IDLE)) << bench.told();
  EXPECT_FALSE(bench.rig().isPowered()) << "a reset gives no power";
}

TEST_F(BridgeOnADevice, TerminatedItBrakesAndSwitchesOff) {
  moveOn();
  bench.bridge().send(SIGTERM);
  EXPECT_EQ(bench.bridge().wait(), 0) << bench.told();
  EXPECT_FALSE(bench.rig().isPowered());
}

TEST_F(BridgeOnADevice, AServerThatStopsMakesItHoldThenGoOff) {
  moveOn();
  server.reset();
  EXPECT_TRUE(goesOff()) << bench.told();
  EXPECT_TRUE(bench.status(v1::BRIDGE_IDLE)) << bench.told();
  server = std::make_unique<StandInServer>(network, "three", three_joints);
  server->stream({0.1, 0.1, 0.1});
  expectStandsStill();
  EXPECT_FALSE(bench.rig().isPowered()) << "a returning stream resumes nothing";
}

// Poses answer edits, and after the pause nobody edits.
TEST_F(BridgeOnADevice, AfterAServersPauseItCanBeArmedWithoutAnEdit) {
  moveOn();
  server->pause(true);
  EXPECT_TRUE(goesOff()) << bench.told();
  EXPECT_TRUE(bench.status(v1::BRIDGE_IDLE)) << bench.told();
  server->pause(false);
  expectStandsStill();
  EXPECT_TRUE(bench.arm()) << bench.told();
}

TEST_F(BridgeOnADevice, AFaultNamesMotorAndJointAndSaysItInWords) {
  moveOn();
  bench.rig().breakDown();
  const auto status = bench.status(v1::BRIDGE_FAULT);
  ASSERT_TRUE(status.has_value()) << bench.told();
  EXPECT_NE(status->reason().find("motor 'm1' (id 1, joint 'b'): hardware error: overload "
                                  "(code 0x20)"),
            std::string::npos)
      << status->reason();
}

TEST_F(BridgeOnADevice, ClampingIsToldWithWhatWasAskedAndGiven) {
  moveOn();
  server->stream({2.4, -2.4, 4.3});
  const auto status = bench.status([](const v1::BridgeStatus& told) {
    return !told.clamping().empty();
  });
  ASSERT_TRUE(status.has_value()) << bench.told();
  EXPECT_EQ(status->clamping(), "'c' asked for 4.3 rad, given 2.5");
  EXPECT_NEAR(status->clamped_rad(), 1.8, 1e-3);
  EXPECT_TRUE(bench.arrive(
      [] {
        return std::vector<double>{2.4, -2.4, 2.5};
      },
      5e-3));
  EXPECT_TRUE(bench.bridge().waitForText("reached as far as the limits permit"))
      << bench.told();
}

TEST_F(BridgeOnADevice, APoseOfNoNumbersIsRefusedAndNotReached) {
  bench.startBridge();
  server->stream({0.1, 0.1, 0.1});
  ASSERT_TRUE(bench.arm()) << bench.told();
  ASSERT_TRUE(bench.bridge().waitForText("pose 1 reached")) << bench.told();
  server->stream({std::nan(""), 0.1, 0.1});
  const auto status = bench.status([](const v1::BridgeStatus& told) {
    return told.refusal() == v1::REFUSAL_POSE;
  });
  ASSERT_TRUE(status.has_value()) << bench.told();
  EXPECT_EQ(status->last_refusal(), "pose refused: not finite");
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  EXPECT_EQ(bench.told().find("pose 2 reached"), std::string::npos) << bench.told();
}

TEST_F(BridgeOnADevice, ALongStepFromRestIsGoneToSlowly) {
  bench.startBridge();
  server->stream({0.1, 0.1, 0.1});
  ASSERT_TRUE(bench.arm()) << bench.told();
  ASSERT_TRUE(bench.bridge().waitForText("pose 1 reached")) << bench.told();
  server->stream({0.1, 2.4, 0.1});
  EXPECT_TRUE(bench.status([](const v1::BridgeStatus& told) {
    return told.slow() && told.state() == v1::BRIDGE_ARMED;
  })) << bench.told();
}

TEST_F(BridgeOnADevice, AnArmingBeforeItsTimeIsNotReplayed) {
  server->stream({0.3, 0.3, 0.3});
  bench.shout(v1::COMMAND_ARM);
  bench.startBridge();
  ASSERT_TRUE(bench.status([](const v1::BridgeStatus& status) {
    return status.state() == v1::BRIDGE_IDLE && status.poses_accepted() > 0;
  })) << bench.told();
  std::this_thread::sleep_for(std::chrono::seconds(1));
  EXPECT_FALSE(bench.rig().isPowered());
  EXPECT_EQ(bench
                .status([](const v1::BridgeStatus&) {
                  return true;
                })
                ->power(),
            v1::POWER_OFF);
}

TEST_F(BridgeOnADevice, UnpluggedAndPluggedInAgainItStaysDisarmed) {
  moveOn();
  bench.rig().wire().unplug();
  const auto status = bench.status(v1::BRIDGE_FAULT);
  ASSERT_TRUE(status.has_value()) << bench.told();
  EXPECT_EQ(status->fault(), v1::FAULT_WIRE) << status->reason();
  bench.rig().wire().plug();
  EXPECT_TRUE(goesOff());
  bench.command(v1::COMMAND_RESET);
  ASSERT_TRUE(bench.status(v1::BRIDGE_IDLE)) << bench.told();
  expectStandsStill();
  EXPECT_FALSE(bench.rig().isPowered());
}

TEST_F(BridgeOnADevice, AnotherHandInTheFollowedSessionEndsItsStream) {
  moveOn();
  server->take("three_left");
  server->stream({-2.4, 2.4, -2.4});
  EXPECT_TRUE(goesOff()) << bench.told();
  EXPECT_TRUE(bench.status(v1::BRIDGE_IDLE)) << bench.told();
  bench.command(v1::COMMAND_ARM);
  const auto refused = bench.status([](const v1::BridgeStatus& told) {
    return !told.last_refusal().empty();
  });
  ASSERT_TRUE(refused.has_value());
  EXPECT_EQ(refused->refusal(), v1::REFUSAL_NO_FRESH_POSE);
  EXPECT_EQ(refused->last_refusal(),
            "ARM refused: no fresh pose: session 11 is of hand 'three_left', this one is "
            "'three': passed over; if it is the same hand, its config and its calibration have "
            "to say hand: 'three_left'");
  server->take("three_left");  // published anew, as by an edit there
  server->take("three");
  server->stream({0.1, 0.1, 0.1});
  expectStandsStill();
  EXPECT_FALSE(bench.rig().isPowered()) << "an undo resumes nothing";
  const std::string told = bench.told();
  const std::string once = "session 11 is of hand";
  EXPECT_NE(told.find(once), std::string::npos) << told;
  EXPECT_EQ(told.find(once), told.rfind(once)) << told;
  EXPECT_TRUE(bench.arm()) << bench.told();
}

TEST_F(BridgeOnADevice, ASecondOneOnTheSamePortDoesNotDisturbIt) {
  moveOn();
  Process second(program("handgraft-bridge"), bench.argumentsOf(2));
  EXPECT_TRUE(second.waitForText("is in use by another process")) << second.err();
  const auto status = bench.status([](const v1::BridgeStatus& told) {
    return told.bridge_id() == 1;
  });
  ASSERT_TRUE(status.has_value());
  EXPECT_EQ(status->state(), v1::BRIDGE_ARMED) << status->reason();
}

TEST_F(BridgeOnADevice, ASecondOneOfTheSameNumberDoesNotStart) {
  moveOn();
  const Finished second =
      run(program("handgraft-bridge"), {"--domain", std::to_string(domain.number())});
  EXPECT_EQ(second.exit_code, 1);
  for (const char* part : {"bridge 1 is there already", "dynamixel ", "--bridge-id"})
    EXPECT_NE(second.err.find(part), std::string::npos) << second.err;
  EXPECT_TRUE(bench.rig().isPowered());
}

// Whoever is suspended is not heard by the one that starts meanwhile.
TEST_F(BridgeOnADevice, TwoOfTheSameNumberAreNotArmed) {
  bench.startBridge();
  server->stream({0.0, 0.0, 0.0});
  ASSERT_TRUE(bench.status(v1::BRIDGE_IDLE)) << bench.told();
  bench.bridge().send(SIGSTOP);
  Process second(program("handgraft-bridge"),
                 {"--disarmed", "--domain", std::to_string(domain.number())});
  ASSERT_TRUE(second.waitForText("no hand yet")) << second.err();
  bench.bridge().send(SIGCONT);
  const auto warned = [](const char* device) {
    return [device](const v1::BridgeStatus& told) {
      return told.device().rfind(device, 0) == 0 &&
             told.reason().find("another bridge 1 is there") != std::string::npos;
    };
  };
  ASSERT_TRUE(bench.status(warned("dynamixel"))) << bench.told();
  ASSERT_TRUE(bench.status(warned("simulated"))) << second.err();
  bench.command(v1::COMMAND_ARM);
  const auto refused = bench.status([](const v1::BridgeStatus& told) {
    return told.device().rfind("dynamixel", 0) == 0 && !told.last_refusal().empty();
  });
  ASSERT_TRUE(refused.has_value()) << bench.told();
  EXPECT_EQ(
      refused->last_refusal().rfind("ARM refused: another bridge 1 is there: simulated", 0), 0)
      << refused->last_refusal();
  EXPECT_FALSE(bench.rig().isPowered());
  second.send(SIGTERM);
  EXPECT_EQ(second.wait(), 0) << second.err();
  ASSERT_TRUE(bench.status([](const v1::BridgeStatus& told) {
    return told.reason().find("another bridge") == std::string::npos;
  })) << bench.told();
  EXPECT_TRUE(bench.arm()) << bench.told();
}

TEST(BridgeConfig, RefusesAPortWithoutAName) {
  const auto path = scratchDirectory() / "three.yaml";
  std::ofstream(path) << directConfig("dynamixel", "three", three_joints, 2.5);
  const Finished finished =
      run(program("handgraft-bridge"), {"--config", path.string(), "--port", ""});
  EXPECT_EQ(finished.exit_code, 2);
  EXPECT_NE(finished.err.find("--port ''"), std::string::npos) << finished.err;
}

TEST(BridgeConfig, EverythingThatIsWrongIsToldBeforeAnythingMoves) {
  const auto path = scratchDirectory() / "wrong.yaml";
  std::string text = directConfig("dynamixel", "three", three_joints, 2.5);
  text.replace(text.find("rate_hz: 20"), 11, "rate_hz: 5000");
  text.replace(text.find("brake_ms: 1000"), 14, "brake_mm: 1000");
  std::ofstream(path) << text;
  const Finished finished = run(program("handgraft-bridge"), {"--config", path.string()});
  EXPECT_EQ(finished.exit_code, 2);
  EXPECT_NE(finished.err.find("rate_hz"), std::string::npos) << finished.err;
  EXPECT_NE(finished.err.find("brake_mm"), std::string::npos) << finished.err;
}

}  // namespace
}  // namespace handgraft::test
