#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "idl/common.h"

namespace handgraft::client {

/// A posed hand as a file tells it.
struct PoseFile {
  std::vector<std::string> joints;
  std::vector<double> joint_rad;  ///< in the order of `joints`
  std::optional<v1::Pose> X_WH;
  std::optional<v1::Pose> X_WO;
  std::map<std::string, v1::Pose> links_X_WL;  ///< of results of `grasp` alone
};

/// Reads `handgraft-grasp/1`, as `grasp --out` writes it, or
///
///     {"joints": {"thumb_mcp": 0.4, ...},
///      "X_WH": {"p_m": [x, y, z], "q_wxyz": [w, x, y, z]},
///      "X_WO": {...}}
///
/// where only `joints` must be there (it may be empty) and no other field may.
/// Errors: InvalidInput naming the file and the field.
PoseFile readPose(const std::filesystem::path& path);

}  // namespace handgraft::client
