// The example configs in the real process: on ttys, over DDS, commanded by the CLI.

#include <algorithm>
#include <cmath>
#include <filesystem>

#include <gtest/gtest.h>

#include "hardware/config/calibration_file.h"
#include "hardware/config/hand_config_file.h"

#include "tests/support/shared_data.h"
#include "tests/support/test_domain.h"
#include "tests/system/bridge_bench.h"
#include "tests/system/service.h"

namespace handgraft::test {
namespace {

std::vector<std::string> jointsOf(const config::HandConfig& config) {
  return config.governor.names;
}

/// Every joint at `share` of its range.
std::vector<double> poseAt(const config::HandConfig& config, double share) {
  std::vector<double> pose;
  for (const safety::JointLimits& limits : config.governor.limits)
    pose.push_back(limits.lower + share * (limits.upper - limits.lower));
  return pose;
}

std::vector<double> motorsOf(const config::HandConfig& config,
                             const std::vector<double>& pose) {
  std::vector<double> motors(config.motors.size());
  std::vector<double> residual(pose.size());
  config::makeMotorMap(config)->command(pose, motors, residual);
  return motors;
}

class ExampleConfig : public testing::Test {
 protected:
  [[nodiscard]] Finished ask(const char* what) const {
    return run(program("handgraft"),
               {"bridge", what, "--domain", std::to_string(domain.number())});
  }

  /// Streams a pose, arms by way of the CLI, and waits until the motors are there.
  void moveTo(BridgeBench& bench,
              StandInServer& server,
              double share,
              const std::vector<double>& offsets,
              double tolerance_rad) {
    const std::vector<double> pose = poseAt(bench.config(), share);
    server.stream(pose);
    std::vector<double> goals = motorsOf(bench.config(), pose);
    for (std::size_t i = 0; i < goals.size(); ++i)
      goals[i] += offsets[i];
    const bool is_there = bench.arrive(
        [&] {
          return goals;
        },
        tolerance_rad);
    for (std::size_t i = 0; i < goals.size(); ++i)
      EXPECT_NEAR(bench.rig().angle(i), goals[i], tolerance_rad) << "motor " << i;
    EXPECT_TRUE(is_there) << share << "\n" << bench.told();
  }

  TestDomain domain;
  Network network{domain.number(), "lo"};
};

class DirectExample : public ExampleConfig, public testing::WithParamInterface<const char*> {};

TEST_P(DirectExample, MovesItsHandAndStops) {
  BridgeBench bench(network, patientExample(GetParam()));
  StandInServer server(network, bench.config().hand, jointsOf(bench.config()));
  bench.startBridge();
  const std::vector<double> none(bench.config().motors.size(), 0.0);
  moveTo(bench, server, 0.4, none, 5e-3);
  moveTo(bench, server, 0.8, none, 5e-3);
  EXPECT_EQ(ask("estop").exit_code, 0);
  EXPECT_FALSE(bench.rig().isPowered());
  EXPECT_EQ(ask("reset").exit_code, 0);
  EXPECT_EQ(bench.stopBridge(), 0) << bench.told();
}

INSTANTIATE_TEST_SUITE_P(Hands,
                         DirectExample,
                         testing::Values("leap", "ability_hand", "inspire_rh56", "allegro"),
                         [](const auto& told) {
                           return std::string(told.param);
                         });

TEST_F(ExampleConfig, TheTendonHandIsHomedByTheCliThenMovesAndKeepsItsZeros) {
  const auto folder = scratchDirectory();
  const auto calibration = folder / "tendon_calibration.yaml";
  std::filesystem::remove(calibration);
  BridgeBench bench(network, patientExample("printed_tendon_hand") +
                                 "calibration: tendon_calibration.yaml\n");
  const std::vector<double> taut_rad = slackenLines(bench.rig(), bench.config());
  StandInServer server(network, bench.config().hand, jointsOf(bench.config()));
  bench.startBridge();
  server.stream(poseAt(bench.config(), 0.1));
  ASSERT_TRUE(bench.status(v1::BRIDGE_IDLE)) << bench.told();

  const Finished early = ask("arm");
  EXPECT_EQ(early.exit_code, 1);
  EXPECT_NE(early.err.find("HOME"), std::string::npos) << early.err;
  EXPECT_FALSE(bench.rig().isPowered());

  // On a busy machine a device may wait for too long, which ends the homing, and rightly so.
  Finished homed = ask("home");
  for (int attempt = 0; attempt < 5 && homed.exit_code != 0; ++attempt) {
    static_cast<void>(ask("reset"));
    homed = ask("home");
  }
  ASSERT_EQ(homed.exit_code, 0) << homed.err << bench.told();
  EXPECT_FALSE(bench.rig().isPowered()) << "homing ends with the motors off";
  ASSERT_TRUE(std::filesystem::exists(calibration)) << bench.told();
  config::HandConfig found = bench.config();
  config::readCalibration(calibration, found);
  std::vector<double> offsets;
  const std::vector<double> zeros_rad = zerosOfShafts(bench.rig(), found);
  for (std::size_t i = 0; i < taut_rad.size(); ++i) {
    EXPECT_NEAR(zeros_rad[i], taut_rad[i], 0.05);
    offsets.push_back(found.motors[i].direction * zeros_rad[i]);
  }
  moveTo(bench, server, 0.5, offsets, 5e-3);
  EXPECT_EQ(bench.stopBridge(), 0) << bench.told();

  // Its zeros are known when it starts again.
  bench.startBridge();
  server.stream(poseAt(bench.config(), 0.3));
  const auto status = bench.status([](const v1::BridgeStatus& told) {
    return told.state() == v1::BRIDGE_IDLE && told.homed() && told.periods() < 500;
  });
  ASSERT_TRUE(status) << bench.told();
  EXPECT_TRUE(status->homed());
  moveTo(bench, server, 0.3, offsets, 5e-3);
}

}  // namespace
}  // namespace handgraft::test
