#pragma once

#include <filesystem>
#include <mutex>
#include <string>

#include "hardware/config/hand_config.h"

namespace handgraft::bridge {

/// Zeros that homing found go to the config's calibration file, and those of before are gone
/// once it begins.
///
/// Threads: `keep` and `drop` on the motion's, with the motors off; `takeText` on the bridge's.
class CalibrationKeeper {
 public:
  void keep(const config::HandConfig& homed);

  /// Should homing not end, there must be no zeros of before to start from. Empty: no file.
  void drop(const std::filesystem::path& path);

  /// What there is to say of it since this was last asked; empty: nothing.
  std::string takeText();

 private:
  void say(std::string text);

  std::mutex mutex_;
  std::string text_;  // guarded by mutex_
};

}  // namespace handgraft::bridge
