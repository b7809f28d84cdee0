// The text of a calibration file, of a hand with two motors that is fixed.

#include <cmath>
#include <cstdint>
#include <string>

#include "core/base/error.h"
#include "hardware/config/calibration_file.h"

#include "tests/fuzz/promise.h"

namespace {

using handgraft::config::HandConfig;

HandConfig twoMotors() {
  HandConfig config;
  config.hand = "h";
  config.motors.resize(2);
  config.motors[0].name = "a";
  config.motors[1].name = "b";
  config.motors[1].zero_rad = 0.25;
  return config;
}

bool isSame(const HandConfig& one, const HandConfig& other) {
  for (std::size_t i = 0; i < one.motors.size(); ++i) {
    if (one.motors[i].zero_rad != other.motors[i].zero_rad ||
        one.motors[i].direction != other.motors[i].direction) {
      return false;
    }
  }
  return true;
}

}  // namespace

// NOLINTNEXTLINE(readability-identifier-naming): libFuzzer's name.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(bytes), size);
  HandConfig config = twoMotors();
  try {
    handgraft::config::parseCalibration(text, config);
  } catch (const handgraft::InvalidInput& error) {
    HANDGRAFT_PROMISE(error.what()[0] != '\0');
    HANDGRAFT_PROMISE(isSame(config, twoMotors()));  // nothing of it was taken
    return 0;
  }
  for (const auto& motor : config.motors) {
    HANDGRAFT_PROMISE(std::isfinite(motor.zero_rad));
    HANDGRAFT_PROMISE(motor.direction == 1 || motor.direction == -1);
  }
  HandConfig again = twoMotors();
  handgraft::config::parseCalibration(handgraft::config::calibrationText(config), again);
  HANDGRAFT_PROMISE(isSame(again, config));
  return 0;
}
