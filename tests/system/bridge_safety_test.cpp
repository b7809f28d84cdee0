// Four ways to hurt a hand, in the real process on a tty: zeros that were lost with the power,
// a watchdog that is not on, a homing that failed, and one that nothing in the device limits.

#include <csignal>
#include <filesystem>
#include <functional>
#include <thread>

#include <gtest/gtest.h>

#include "tests/support/shared_data.h"
#include "tests/support/test_domain.h"
#include "tests/system/bridge_bench.h"
#include "tests/system/service.h"

namespace handgraft::test {
namespace {

/// A printed hand with tendons, on three ODrive axes whose encoders count from 0 at power-up.
class TendonHandOnATty : public testing::Test {
 protected:
  TendonHandOnATty() {
    std::filesystem::remove(calibration);
    taut_rad = slackenLines(bench.rig(), bench.config());
  }

  static std::string configText() {
    std::string text = patientExample("printed_tendon_hand");
    // Each homing step proves the watchdog by silence.
    replace(text, "watchdog_ms: 2500", "watchdog_ms: 1500");
    // A shorter way to find nothing in, and quicker.
    for (int i = 0; i < 3; ++i) {
      replace(text, "travel_rad: 12", "travel_rad: 5");
      replace(text, "speed_rad_s: 0.5", "speed_rad_s: 1");
    }
    return text + "calibration: tendon_safety_calibration.yaml\n";
  }

  [[nodiscard]] Finished ask(const char* what) const {
    return run(program("handgraft"),
               {"bridge", what, "--domain", std::to_string(domain.number())});
  }

  /// Does something to each axis.
  void toAxes(const std::function<void(int node, ODriveEmulator::Axis& axis)>& act) {
    const auto lock = bench.rig().wire().hold();
    for (const config::MotorConfig& motor : bench.config().motors)
      act(motor.id, busOf(bench.rig()).axis(motor.id));
  }

  void start() {
    bench.startBridge();
    server.stream(openHand());
    ASSERT_TRUE(bench.status([](const v1::BridgeStatus& told) {
      return told.state() == v1::BRIDGE_IDLE && told.poses_accepted() > 0;
    })) << bench.told();
  }

  /// On a busy machine a device may wait for too long, which ends a homing, and rightly so.
  void home() {
    Finished homed = ask("home");
    for (int attempt = 0; attempt < 5 && homed.exit_code != 0; ++attempt) {
      static_cast<void>(ask("reset"));
      homed = ask("home");
    }
    ASSERT_EQ(homed.exit_code, 0) << homed.err << bench.told();
    ASSERT_TRUE(std::filesystem::exists(calibration));
  }

  /// The device's own watchdog is what switches it off.
  void awaitPowerOff() {
    for (int i = 0; i < 200 && bench.rig().isPowered(); ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    EXPECT_FALSE(bench.rig().isPowered());
  }

  [[nodiscard]] std::vector<double> openHand() const {
    std::vector<double> pose;
    for (const safety::JointLimits& limits : bench.config().governor.limits)
      pose.push_back(limits.lower);
    return pose;
  }

  std::vector<double> shafts() {
    std::vector<double> turns;
    toAxes([&](int, ODriveEmulator::Axis& axis) {
      turns.push_back(axis.servo.position);
    });
    return turns;
  }

  void expectIsNotArmed(v1::BridgeRefusal code, const std::string& why) {
    const std::vector<double> before = shafts();
    const Finished armed = ask("arm");
    EXPECT_EQ(armed.exit_code, 1) << bench.told();
    EXPECT_NE(armed.err.find(why), std::string::npos) << armed.err;
    const auto told = bench.status([code](const v1::BridgeStatus& status) {
      return status.refusal() == code;
    });
    EXPECT_TRUE(told.has_value()) << bench.told();
    EXPECT_FALSE(bench.rig().isPowered());
    EXPECT_EQ(shafts(), before) << "nothing turned";
  }

  TestDomain domain;
  Network network{domain.number(), "lo"};
  std::filesystem::path calibration = scratchDirectory() / "tendon_safety_calibration.yaml";
  BridgeBench bench{network, configText()};
  StandInServer server{network, bench.config().hand, bench.config().governor.names};
  std::vector<double> taut_rad;
};

// === 1. Lost zeros

TEST_F(TendonHandOnATty, ThatLostItsPowerIsNotArmedOnItsOldZeros) {
  start();
  home();
  ASSERT_TRUE(bench.arm()) << bench.told();
  ASSERT_EQ(bench.stopBridge(), 0) << bench.told();
  toAxes([this](int node, ODriveEmulator::Axis&) {
    busOf(bench.rig()).restart(node);
  });
  start();
  const auto told = bench.status([](const v1::BridgeStatus& status) {
    return !status.homed() && status.periods() > 10;
  });
  ASSERT_TRUE(told.has_value()) << bench.told();
  EXPECT_NE(told->reason().find("motor 'thumb' restarted since it was homed"),
            std::string::npos)
      << told->reason();
  expectIsNotArmed(v1::REFUSAL_NOT_HOMED, "HOME first");
}

TEST_F(TendonHandOnATty, WhoseZerosAreWrongIsNotArmedWhereverItsJointsSeemToBe) {
  start();
  home();
  ASSERT_EQ(bench.stopBridge(), 0) << bench.told();
  // Its lines were slackened by hand: every joint is measured at rest, no drum is where it may
  // be.
  toAxes([](int, ODriveEmulator::Axis& axis) {
    axis.servo.position -= axis.winds * 0.4;
    axis.servo.goal = axis.servo.position;
  });
  start();
  expectIsNotArmed(v1::REFUSAL_MOTORS_OUTSIDE, "its range 0 to 4");
}

TEST_F(TendonHandOnATty, ThatCannotSayWhetherItRestartedIsHomedAnew) {
  toAxes([](int, ODriveEmulator::Axis& axis) {
    axis.takes_positions = false;
  });
  start();
  home();
  ASSERT_TRUE(bench.arm()) << bench.told();
  ASSERT_EQ(bench.stopBridge(), 0) << bench.told();
  start();
  expectIsNotArmed(v1::REFUSAL_NOT_HOMED, "cannot say whether it restarted");
}

// === 2. A watchdog that nobody proved

TEST_F(TendonHandOnATty, WithoutAnAxisWatchdogIsNotArmed) {
  start();
  home();
  {
    const auto lock = bench.rig().wire().hold();
    busOf(bench.rig()).axis(1).watchdog = Duration::zero();
  }
  EXPECT_EQ(ask("arm").exit_code, 1) << bench.told();
  const auto told = bench.status(v1::BRIDGE_FAULT);
  ASSERT_TRUE(told.has_value()) << bench.told();
  EXPECT_EQ(told->fault(), v1::FAULT_NO_WATCHDOG) << told->reason();
  EXPECT_NE(told->reason().find("motor 'index' (id 1)"), std::string::npos) << told->reason();
  EXPECT_NE(told->reason().find("enable_watchdog"), std::string::npos) << told->reason();
  EXPECT_FALSE(bench.rig().isPowered());
}

TEST_F(TendonHandOnATty, KilledItsOwnWatchdogSwitchesItOff) {
  start();
  home();
  ASSERT_TRUE(bench.arm()) << bench.told();
  bench.bridge().send(SIGKILL);
  EXPECT_EQ(bench.bridge().wait(), 128 + SIGKILL);
  awaitPowerOff();
}

// === 3. A homing that failed

TEST_F(TendonHandOnATty, WhoseHomingFailsHasNoZerosAnyMore) {
  start();
  home();
  toAxes([](int, ODriveEmulator::Axis& axis) {
    axis.taut.reset();  // the line came off its drum
  });
  const Finished failed = ask("home");
  EXPECT_EQ(failed.exit_code, 1) << failed.out;
  for (const char* part : {"homing of 'thumb'", "found no stop", "of 5 rad"})
    EXPECT_NE(failed.err.find(part), std::string::npos) << failed.err;
  EXPECT_FALSE(std::filesystem::exists(calibration)) << "the old zeros are void";
  EXPECT_FALSE(bench.rig().isPowered());
  expectIsNotArmed(v1::REFUSAL_NOT_HOMED, "found no stop");
}

TEST_F(TendonHandOnATty, KilledInItsHomingHasNoZerosWhenItComesBack) {
  start();
  home();
  Process homing(program("handgraft"),
                 {"bridge", "home", "--domain", std::to_string(domain.number())});
  ASSERT_TRUE(bench.status([](const v1::BridgeStatus& told) {
    return told.homing() && told.power() == v1::POWER_ON;
  })) << bench.told();
  bench.bridge().send(SIGKILL);
  static_cast<void>(bench.bridge().wait());
  EXPECT_EQ(homing.wait(), 1) << "whoever asked for it is told";
  EXPECT_NE(homing.err().find("has fallen silent"), std::string::npos) << homing.err();
  awaitPowerOff();
  bench.startBridge();
  server.stream(openHand());
  ASSERT_TRUE(bench.status([](const v1::BridgeStatus& told) {
    return told.state() == v1::BRIDGE_FAULT && told.poses_accepted() > 0;
  })) << "its watchdog fired: "
      << bench.told();
  EXPECT_EQ(ask("reset").exit_code, 0) << bench.told();
  expectIsNotArmed(v1::REFUSAL_NOT_HOMED, "HOME first");
}

// === 4. A homing that nothing in the device limits

TEST_F(TendonHandOnATty, IsHomedWithTheDevicesOwnLimitsSetAndSetBack) {
  start();
  home();
  for (std::size_t i = 0; i < bench.config().homing.size(); ++i) {
    const auto lock = bench.rig().wire().hold();
    const safety::HomingStep& step = bench.config().homing[i];
    const config::MotorConfig& motor = bench.config().motors[step.motor];
    const ODriveEmulator::Axis& axis = busOf(bench.rig()).axis(motor.id);
    EXPECT_LE(axis.largest_current_A, 1.25 * step.current_A + 1e-6) << motor.name;
    // Half a second's way and 0.1 rad, in turns.
    EXPECT_LE(axis.largest_lead, (0.5 * step.speed_rad_s + 0.15) / 6.28) << motor.name;
    EXPECT_EQ(axis.current_limit_A, motor.current_A) << "set back";
  }
}

TEST_F(TendonHandOnATty, WhoseAxisStopsTellingItsCurrentIsNotRunOn) {
  start();
  const auto turns = [this] {
    const auto lock = bench.rig().wire().hold();
    return busOf(bench.rig()).axis(0).servo.position;
  };
  const double start_turns = turns();
  // On a busy machine a homing may end before it turns anything, and is asked for again.
  for (int i = 0; i < 6000 && turns() - start_turns < 0.02; ++i) {
    if (i % 500 == 0) {
      bench.shout(v1::COMMAND_RESET);
      bench.command(v1::COMMAND_HOME);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  ASSERT_GE(turns() - start_turns, 0.02) << bench.told();
  double told_turns = 0;
  {
    const auto lock = bench.rig().wire().hold();
    ODriveEmulator::Axis& axis = busOf(bench.rig()).axis(0);
    axis.tells_current = false;
    axis.taut.reset();
    told_turns = axis.servo.position;
  }
  const auto ended = bench.status([](const v1::BridgeStatus& told) {
    return !told.homing() && told.power() == v1::POWER_OFF &&
           told.state() != v1::BRIDGE_DISCONNECTED;
  });
  ASSERT_TRUE(ended.has_value()) << bench.told();
  EXPECT_FALSE(ended->homed());
  EXPECT_LT(turns() - told_turns, 0.25) << "turns, of the 0.8 that it was given";
  EXPECT_FALSE(bench.rig().isPowered());
}

}  // namespace
}  // namespace handgraft::test
