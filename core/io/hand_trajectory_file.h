#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/base/pose.h"

namespace handgraft::io {

inline constexpr const char* kTrajectoryFormat = "handgraft-trajectory/1";

/// What a hand whose joints are known did, and the object, as a file tells it.
struct HandTrajectoryFile {
  struct Frame {
    double time_s = 0.0;
    Pose X_WH = Pose::Identity();
    Pose X_WO = Pose::Identity();
    Eigen::VectorXd q;  ///< in the order of `joints`; rad, or m where a joint slides
  };

  std::string object;  ///< what it is called; empty where the file does not say
  std::vector<std::string> joints;
  bool tells_root = false;    ///< X_WH; else it is the identity, or what joints say
  std::vector<Frame> frames;  ///< at least one, by rising time
};

/// Reads `handgraft-trajectory/1`, or the CSV of the same (FORMATS.md), which `motion solve`
/// and `motion export` write. Only time and joints must be there; the rest, and what is told of
/// contacts, may be missing.
/// Errors: InvalidInput naming the file, the field and the frame or the line.
HandTrajectoryFile readHandTrajectory(const std::filesystem::path& path);

}  // namespace handgraft::io
