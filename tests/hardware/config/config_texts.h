#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "hardware/config/hand_config_file.h"
#include "hardware/config/text_file.h"

#include "tests/support/shared_data.h"

/// Configs that are sound, and what is said of those that are not.
namespace handgraft::config::texts {

inline const std::vector<std::string> example_configs{
    "leap",         "ability_hand", "printed_tendon_hand",
    "inspire_rh56", "allegro",      "printed_gripper"};

inline std::filesystem::path examplePath(const std::string& name) {
  return test::sourceDirectory() / "hardware" / "config" / "examples" / (name + ".yaml");
}

inline std::string exampleText(const std::string& name) {
  return readText(examplePath(name));
}

/// What is said of a config that is wrong; empty if nothing is.
inline std::string objectionTo(const std::string& text) {
  try {
    parseHandConfig(text);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

inline bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// A hand of one finger, as small as a config may be.
inline constexpr const char* kSmall = R"(
format: handgraft-hardware/1
hand: small
device: {kind: simulated}
motion: {velocity_rad_s: 2, acceleration_rad_s2: 20, jerk_rad_s3: 400}
joints:
  - {name: a, lower_rad: 0, upper_rad: 1.5}
  - {name: b, lower_rad: -0.5, upper_rad: 1}
motors:
  - {name: m, lower_rad: 0, upper_rad: 1.5, velocity_rad_s: 2}
  - {name: n, lower_rad: -0.5, upper_rad: 1, velocity_rad_s: 2}
)";

inline std::string smallWith(const std::string& old_text, const std::string& new_text) {
  std::string text = kSmall;
  const auto at = text.find(old_text);
  EXPECT_NE(at, std::string::npos) << old_text;
  return text.replace(at, old_text.size(), new_text);
}

}  // namespace handgraft::config::texts
