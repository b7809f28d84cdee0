#include "hardware/bridge/calibration_keeper.h"

#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "core/base/error.h"
#include "hardware/config/calibration_file.h"

namespace handgraft::bridge {

void CalibrationKeeper::keep(const config::HandConfig& homed) {
  std::string text = "homed";
  try {
    if (homed.calibration.empty()) {
      text += "; the config names no calibration file to keep the zeros in";
    } else {
      config::writeCalibration(homed.calibration, homed);
      text +=
          fmt::format("; zeros are kept in {}", handgraft::quoted(homed.calibration.string()));
    }
  } catch (const InvalidInput& error) {
    text += fmt::format("; zeros are lost when this ends: {}", error.what());
  }
  say(std::move(text));
}

void CalibrationKeeper::drop(const std::filesystem::path& path) {
  if (path.empty()) return;
  std::error_code error;
  std::filesystem::remove(path, error);
  if (!error) return;
  say(fmt::format("{} has zeros that are void, and cannot be removed: {}",
                  handgraft::quoted(path.string()), error.message()));
}

std::string CalibrationKeeper::takeText() {
  const std::lock_guard lock(mutex_);
  return std::exchange(text_, {});
}

void CalibrationKeeper::say(std::string text) {
  const std::lock_guard lock(mutex_);
  text_ = std::move(text);
}

}  // namespace handgraft::bridge
