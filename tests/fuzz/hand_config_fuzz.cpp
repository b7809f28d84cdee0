// The text of a hand's config, and behind `#CALIBRATION` of its calibration; then what a bridge
// makes of it: governor, transmission, poses there and back.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "hardware/config/calibration_file.h"
#include "hardware/config/hand_config_file.h"
#include "hardware/safety/governor.h"

#include "tests/fuzz/promise.h"

namespace {

using handgraft::config::HandConfig;

constexpr const char* kMark = "#CALIBRATION";

bool allFinite(const std::vector<double>& numbers) {
  for (const double number : numbers) {
    if (!std::isfinite(number)) return false;
  }
  return true;
}

/// A pose in the middle and at both ends: motors are within what the map itself promises.
void checkTransmission(const HandConfig& config) {
  const auto map = handgraft::config::makeMotorMap(config);
  HANDGRAFT_PROMISE(map->jointCount() == config.jointCount());
  HANDGRAFT_PROMISE(map->motorCount() == config.motors.size());
  std::vector<double> joints(config.jointCount());
  std::vector<double> motors(config.motors.size());
  std::vector<double> residual(config.jointCount());
  std::vector<double> measured(config.jointCount());
  for (const double share : {0.0, 0.5, 1.0}) {
    for (std::size_t i = 0; i < joints.size(); ++i) {
      const auto& limits = config.governor.limits[i];
      joints[i] = limits.lower + share * (limits.upper - limits.lower);
    }
    map->command(joints, motors, residual);
    map->measure(motors, measured);
    HANDGRAFT_PROMISE(allFinite(motors));
    HANDGRAFT_PROMISE(allFinite(residual));
    HANDGRAFT_PROMISE(allFinite(measured));
  }
}

/// What is written reads back as what it was.
void checkCalibration(const HandConfig& config) {
  HandConfig again = config;
  handgraft::config::parseCalibration(handgraft::config::calibrationText(config), again);
  for (std::size_t i = 0; i < config.motors.size(); ++i) {
    HANDGRAFT_PROMISE(again.motors[i].zero_rad == config.motors[i].zero_rad);
    HANDGRAFT_PROMISE(again.motors[i].direction == config.motors[i].direction);
  }
}

}  // namespace

// NOLINTNEXTLINE(readability-identifier-naming): libFuzzer's name.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(bytes), size);
  const std::size_t mark = std::min(text.find(kMark), text.size());
  try {
    HandConfig config = handgraft::config::parseHandConfig(text.substr(0, mark));
    const handgraft::safety::Governor governor(config.governor);
    HANDGRAFT_PROMISE(governor.state() == handgraft::safety::GovernorState::kDisconnected);
    checkTransmission(config);
    checkCalibration(config);
    handgraft::config::parseCalibration(text.substr(mark), config);
    checkCalibration(config);
  } catch (const handgraft::InvalidInput& error) {
    HANDGRAFT_PROMISE(error.what()[0] != '\0');
  }
  return 0;
}
