#include "hardware/config/calibration_file.h"

#include <algorithm>
#include <set>

#include "core/base/error.h"
#include "hardware/config/joint_section.h"
#include "hardware/config/text_file.h"
#include "hardware/config/yaml_section.h"

namespace handgraft::config {

namespace {

// rad, at the encoder: a marked one counts from up to a hundred turns away, and behind gears
// a motor's turn is a thousand of its own.
constexpr double kFarthestZero = 1e6;

void readMotors(Section& file, HandConfig& config, Problems& problems) {
  std::set<std::string> seen;
  for (Section& section : file.list("motors", 1, kMostJoints)) {
    const std::string name = section.text("name");
    const double zero = section.number("zero_rad", -kFarthestZero, kFarthestZero);
    const int direction = section.choice<int>("direction", {{"1", 1}, {"-1", -1}});
    const bool is_marked = section.flag("marked", false);
    section.finish();
    const auto found =
        std::find_if(config.motors.begin(), config.motors.end(), [&](const MotorConfig& m) {
          return m.name == name;
        });
    if (found == config.motors.end() || !seen.insert(name).second) {
      section.object("name",
                     handgraft::quoted(name) + " is no motor of this hand, or there twice");
      continue;
    }
    found->zero_rad = zero;
    found->direction = direction;
    found->is_marked = is_marked;
  }
  for (const MotorConfig& motor : config.motors) {
    if (seen.count(motor.name) == 0)
      problems.push_back("motors: " + handgraft::quoted(motor.name) + " is missing");
  }
}

}  // namespace

void parseCalibration(const std::string& text, HandConfig& config) {
  Problems problems;
  HandConfig calibrated = config;
  try {
    Section file = Section::parse(text, problems);
    file.choice<int>("format", {{"handgraft-calibration/1", 1}});
    const std::string hand = file.text("hand");
    if (problems.empty() && hand != config.hand)
      file.object("hand",
                  handgraft::quoted(hand) + " is not " + handgraft::quoted(config.hand));
    readMotors(file, calibrated, problems);
    file.finish();
  } catch (const YAML::Exception& error) {
    problems.push_back(
        fmt::format("line {}: {}", error.mark.line + 1, handgraft::quoted(error.msg)));
  }
  if (!problems.empty()) throw InvalidInput(fmt::format("{}", fmt::join(problems, "; ")));
  config = std::move(calibrated);
}

void readCalibration(const std::filesystem::path& path, HandConfig& config) {
  const std::string text = readText(path);
  try {
    parseCalibration(text, config);
  } catch (const InvalidInput& error) {
    rejectInput("{}: {}", handgraft::quoted(path.string()), error.what());
  }
}

std::string calibrationText(const HandConfig& config) {
  YAML::Emitter out;
  out.SetDoublePrecision(17);
  out << YAML::Comment(
      "Where the device's encoders stand (rad) when each motor's angle is 0, and whether\n"
      "they count its way. Marked: the device counts from a place of ours since, so that "
      "a\nrestart shows. Written by homing.");
  out << YAML::BeginMap << YAML::Key << "format" << YAML::Value << "handgraft-calibration/1";
  out << YAML::Key << "hand" << YAML::Value << YAML::DoubleQuoted << config.hand;
  out << YAML::Key << "motors" << YAML::Value << YAML::BeginSeq;
  for (const MotorConfig& motor : config.motors) {
    out << YAML::Flow << YAML::BeginMap;
    out << YAML::Key << "name" << YAML::Value << YAML::DoubleQuoted << motor.name;
    out << YAML::Key << "zero_rad" << YAML::Value << motor.zero_rad;
    out << YAML::Key << "direction" << YAML::Value << motor.direction;
    if (motor.is_marked) out << YAML::Key << "marked" << YAML::Value << true;
    out << YAML::EndMap;
  }
  out << YAML::EndSeq << YAML::EndMap;
  HANDGRAFT_REQUIRE(out.good());
  return std::string(out.c_str()) + "\n";
}

void writeCalibration(const std::filesystem::path& path, const HandConfig& config) {
  writeText(path, calibrationText(config));
}

}  // namespace handgraft::config
