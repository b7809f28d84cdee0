#include "core/io/hand_trajectory_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <set>
#include <sstream>
#include <utility>

#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/base/utf8.h"
#include "core/formats/json_keys.h"
#include "core/io/file_bytes.h"
#include "core/manipulation/motion.h"

namespace handgraft::io {
namespace {

using formats::finiteFrom;
using formats::memberOf;
using nlohmann::json;
using Frame = HandTrajectoryFile::Frame;

constexpr std::size_t kMostJoints = 1024;
constexpr std::array<const char*, 7> kPoseEntries = {"x", "y", "z", "qw", "qx", "qy", "qz"};

void requireNames(const std::vector<std::string>& joints) {
  if (joints.empty()) rejectInput("no joint is named");
  if (joints.size() > kMostJoints)
    rejectInput("{} joints are named; at most {} are permitted", joints.size(), kMostJoints);
  std::set<std::string> known;
  for (const std::string& joint : joints)
    if (!known.insert(joint).second) rejectInput("joint {} is named twice", quoted(joint));
}

void appendFrame(Frame frame, HandTrajectoryFile& file) {
  const std::size_t count = file.frames.size();
  if (count >= static_cast<std::size_t>(manipulation::kMostFrames))
    rejectInput("has more than {} frames", manipulation::kMostFrames);
  if (count > 0 && !(frame.time_s > file.frames.back().time_s))
    rejectInput("its time {} s does not lie behind the one before it, {} s", frame.time_s,
                file.frames.back().time_s);
  file.frames.push_back(std::move(frame));
}

// === JSON

Eigen::VectorXd numbersField(const json& values, const char* name, std::size_t count) {
  if (!values.is_array() || values.size() != count)
    rejectInput("field '{}' must be a list of {} numbers", name, count);
  Eigen::VectorXd numbers(static_cast<Eigen::Index>(count));
  for (std::size_t i = 0; i < count; ++i)
    numbers[static_cast<Eigen::Index>(i)] = finiteFrom(values[i], name);
  return numbers;
}

Pose poseField(const json& frame, const char* name) {
  const json& pose = memberOf(frame, name);
  if (!pose.is_object()) rejectInput("field '{}' is no pose of p_m and q_wxyz", name);
  const Eigen::VectorXd p = numbersField(memberOf(pose, "p_m"), "p_m", 3);
  const Eigen::VectorXd q = numbersField(memberOf(pose, "q_wxyz"), "q_wxyz", 4);
  return poseFromQuaternion(p.head<3>(), q.head<4>(), name);
}

std::vector<std::string> jointNamesIn(const json& root) {
  const json& names = memberOf(root, "joint_names");
  if (!names.is_array()) rejectInput("field 'joint_names' is no list");
  std::vector<std::string> joints;
  for (const json& name : names) {
    if (!name.is_string())
      rejectInput("field 'joint_names': {} is no name", formats::shown(name));
    joints.push_back(name.get<std::string>());
  }
  return joints;
}

HandTrajectoryFile trajectoryFrom(const json& root) {
  if (!root.is_object() || root.value("format", json()) != kTrajectoryFormat)
    rejectInput("field 'format' must be '{}'", kTrajectoryFormat);
  HandTrajectoryFile file;
  if (const auto object = root.find("object"); object != root.end() && object->is_string())
    file.object = object->get<std::string>();
  file.joints = jointNamesIn(root);
  requireNames(file.joints);
  const json& frames = memberOf(root, "frames");
  if (!frames.is_array() || frames.empty()) rejectInput("field 'frames' is no list of frames");
  file.tells_root = frames[0].is_object() && frames[0].contains("X_WH");
  for (std::size_t k = 0; k < frames.size(); ++k) {
    try {
      const json& from = frames[k];
      if (!from.is_object()) rejectInput("is no object");
      Frame frame;
      frame.time_s = finiteFrom(memberOf(from, "time_s"), "time_s");
      frame.q = numbersField(memberOf(from, "joints"), "joints", file.joints.size());
      if (file.tells_root) frame.X_WH = poseField(from, "X_WH");
      if (from.contains("X_WO")) frame.X_WO = poseField(from, "X_WO");
      appendFrame(std::move(frame), file);
    } catch (const InvalidInput& error) {
      rejectInput("frame {}: {}", k, error.what());
    }
  }
  return file;
}

// === CSV

/// RFC 4180: a cell with a comma or a quote in it is quoted, a quote within it doubled.
std::vector<std::string> cellsOf(const std::string& line) {
  std::vector<std::string> cells(1);
  bool is_quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (c == '"') {
      if (is_quoted && i + 1 < line.size() && line[i + 1] == '"') {
        cells.back() += line[++i];
      } else {
        is_quoted = !is_quoted;
      }
    } else if (c == ',' && !is_quoted) {
      cells.emplace_back();
    } else {
      cells.back() += c;
    }
  }
  return cells;
}

using PoseColumns = std::array<std::size_t, 7>;

/// Which column is what.
struct Columns {
  std::size_t count = 0;
  std::size_t time = 0;
  std::optional<PoseColumns> X_WH;
  std::optional<PoseColumns> X_WO;
  std::vector<std::size_t> joints;
};

std::size_t columnNamed(const std::vector<std::string>& cells, const std::string& name) {
  const auto at = std::find(cells.begin(), cells.end(), name);
  if (at == cells.end()) rejectInput("column '{}' is missing", name);
  return static_cast<std::size_t>(at - cells.begin());
}

/// None of a pose's columns, or all of them.
std::optional<PoseColumns> poseColumns(const std::vector<std::string>& cells,
                                       const std::string& name) {
  const auto belongs = [&](const std::string& cell) {
    return cell.starts_with(name + ".");
  };
  if (std::none_of(cells.begin(), cells.end(), belongs)) return std::nullopt;
  PoseColumns columns{};
  for (std::size_t i = 0; i < columns.size(); ++i)
    columns[i] = columnNamed(cells, name + "." + kPoseEntries[i]);
  return columns;
}

Columns columnsOf(const std::vector<std::string>& cells, HandTrajectoryFile& file) {
  Columns columns;
  columns.count = cells.size();
  columns.time = columnNamed(cells, "time_s");
  columns.X_WH = poseColumns(cells, "X_WH");
  columns.X_WO = poseColumns(cells, "X_WO");
  std::set<std::size_t> known = {columns.time};
  for (const auto* pose : {&columns.X_WH, &columns.X_WO})
    if (*pose) known.insert((*pose)->begin(), (*pose)->end());
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (known.contains(i) || cells[i] == "max_depth_m" || cells[i] == "self_depth_m") continue;
    columns.joints.push_back(i);
    file.joints.push_back(cells[i]);
  }
  requireNames(file.joints);
  file.tells_root = columns.X_WH.has_value();
  return columns;
}

double numberInCell(const std::string& cell) {
  char* end = nullptr;
  const double value = std::strtod(cell.c_str(), &end);
  if (end == cell.c_str() || *end != '\0' || !std::isfinite(value))
    rejectInput("{} is no finite number", quoted(cell));
  return value;
}

Pose poseInCells(const std::vector<std::string>& cells,
                 const PoseColumns& columns,
                 const char* name) {
  std::array<double, 7> numbers{};
  for (std::size_t i = 0; i < numbers.size(); ++i)
    numbers[i] = numberInCell(cells[columns[i]]);
  const auto& [x, y, z, qw, qx, qy, qz] = numbers;
  return poseFromQuaternion({x, y, z}, {qw, qx, qy, qz}, name);
}

HandTrajectoryFile trajectoryFromCsv(const std::string& bytes) {
  HandTrajectoryFile file;
  Columns columns;
  std::istringstream lines{std::string(withoutByteOrderMark(bytes))};
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (line.empty()) continue;
    try {
      const std::vector<std::string> cells = cellsOf(line);
      if (columns.count == 0) {
        columns = columnsOf(cells, file);
        continue;
      }
      if (cells.size() != columns.count)
        rejectInput("has {} cells; the heading has {}", cells.size(), columns.count);
      Frame frame;
      frame.time_s = numberInCell(cells[columns.time]);
      frame.q.resize(static_cast<Eigen::Index>(columns.joints.size()));
      for (std::size_t i = 0; i < columns.joints.size(); ++i)
        frame.q[static_cast<Eigen::Index>(i)] = numberInCell(cells[columns.joints[i]]);
      if (columns.X_WH) frame.X_WH = poseInCells(cells, *columns.X_WH, "X_WH");
      if (columns.X_WO) frame.X_WO = poseInCells(cells, *columns.X_WO, "X_WO");
      appendFrame(std::move(frame), file);
    } catch (const InvalidInput& error) {
      rejectInput("line {}: {}", number, error.what());
    }
  }
  if (file.frames.empty()) rejectInput("has no frames");
  return file;
}

}  // namespace

HandTrajectoryFile readHandTrajectory(const std::filesystem::path& path) {
  try {
    const std::string bytes = readFileBytes(path);
    const std::size_t first = bytes.find_first_not_of(" \t\r\n");
    const bool is_json = first != std::string::npos && bytes[first] == '{';
    return is_json ? trajectoryFrom(json::parse(bytes)) : trajectoryFromCsv(bytes);
  } catch (const json::exception& error) {
    rejectInput("{}: {}", quoted(path.string()), error.what());
  } catch (const InvalidInput& error) {
    rejectInput("{}: {}", quoted(path.string()), error.what());
  }
}

}  // namespace handgraft::io
