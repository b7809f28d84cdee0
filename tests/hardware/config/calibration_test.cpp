#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "hardware/config/calibration_file.h"
#include "hardware/config/hand_config_file.h"

#include "tests/hardware/config/config_texts.h"

namespace handgraft::config {
namespace {

namespace fs = std::filesystem;
using texts::contains;
using texts::examplePath;
using texts::exampleText;
using texts::kSmall;

TEST(Calibration, ComesBackBitForBit) {
  HandConfig config = readHandConfig(examplePath("printed_tendon_hand"));
  config.motors[0].zero_rad = 0.1 + 0.2;
  config.motors[1].zero_rad = -std::nextafter(1.0, 2.0);
  config.motors[1].direction = -1;
  config.motors[2].zero_rad =
      96 * 2 * std::numbers::pi + 100 * 5.0;  // marked, behind gears of 100
  const fs::path path = test::scratchDirectory() / "calibration.yaml";
  writeCalibration(path, config);
  HandConfig again = readHandConfig(examplePath("printed_tendon_hand"));
  readCalibration(path, again);
  for (std::size_t i = 0; i < config.motors.size(); ++i) {
    EXPECT_EQ(again.motors[i].zero_rad, config.motors[i].zero_rad);
    EXPECT_EQ(again.motors[i].direction, config.motors[i].direction);
  }
}

TEST(Calibration, IsReadWithTheConfigThatNamesIt) {
  const fs::path folder = test::scratchDirectory();
  HandConfig config = parseHandConfig(kSmall);
  config.motors[1].zero_rad = 0.25;
  writeCalibration(folder / "zeros.yaml", config);
  writeText(folder / "small.yaml", std::string(kSmall) + "calibration: zeros.yaml\n");
  EXPECT_EQ(readHandConfig(folder / "small.yaml").motors[1].zero_rad, 0.25);
}

TEST(Calibration, AFileThatIsNotThereMeansThatZerosAreNotKnown) {
  const fs::path folder = test::scratchDirectory();
  writeText(folder / "never_checked.yaml", std::string(kSmall) + "calibration: nowhere.yaml\n");
  EXPECT_FALSE(readHandConfig(folder / "never_checked.yaml").is_calibrated);
  const std::string tendons = exampleText("printed_tendon_hand");
  writeText(folder / "to_be_homed.yaml", tendons + "calibration: later.yaml\n");
  HandConfig config = readHandConfig(folder / "to_be_homed.yaml");
  EXPECT_FALSE(config.is_calibrated);
  EXPECT_EQ(config.calibration, folder / "later.yaml") << "where homing puts what it finds";
  config.motors[2].zero_rad = 1.5;
  writeCalibration(config.calibration, config);
  const HandConfig homed = readHandConfig(folder / "to_be_homed.yaml");
  EXPECT_TRUE(homed.is_calibrated);
  EXPECT_EQ(homed.motors[2].zero_rad, 1.5);
  writeText(folder / "later.yaml", "format: handgraft-calibration/1\nhand: other\n");
  EXPECT_THROW(readHandConfig(folder / "to_be_homed.yaml"), InvalidInput)
      << "one that is wrong is no reason to home, but to look";
}

TEST(Calibration, RefusesOtherHandsAndMissingMotors) {
  const auto objection = [](const std::string& text) -> std::string {
    HandConfig config = parseHandConfig(kSmall);
    try {
      parseCalibration(text, config);
    } catch (const InvalidInput& error) {
      EXPECT_EQ(config.motors[0].zero_rad, 0) << "nothing changed";
      return error.what();
    }
    return "";
  };
  const std::string head = "format: handgraft-calibration/1\nhand: small\nmotors:\n";
  const std::string m = "  - {name: m, zero_rad: 0.5, direction: 1}\n";
  const std::string n = "  - {name: n, zero_rad: 0.5, direction: -1}\n";
  EXPECT_EQ(objection(head + n), objection(head + n));
  EXPECT_TRUE(contains(objection(head + m), "'n' is missing"));
  EXPECT_TRUE(contains(objection(head + m + n + m), "there twice"));
  EXPECT_TRUE(contains(objection(head + m + "  - {name: n, zero_rad: .nan, direction: 1}\n"),
                       "motors[1].zero_rad"));
  EXPECT_TRUE(contains(objection(head + m + "  - {name: n, zero_rad: 0, direction: 2}\n"),
                       "motors[1].direction"));
  EXPECT_TRUE(
      contains(objection("format: handgraft-calibration/1\nhand: big\nmotors:\n" + m + n),
               "'big' is not 'small'"));
  HandConfig config = parseHandConfig(kSmall);
  parseCalibration(head + m + n, config);
  EXPECT_EQ(config.motors[1].direction, -1);
}

}  // namespace
}  // namespace handgraft::config
