#pragma once

#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/geometry/triangle_mesh.h"
#include "core/hand/hand_model.h"
#include "core/hand/kinematics.h"
#include "core/quality/penetration.h"

/// What a hand did over time, for other programs (FORMATS.md).
namespace handgraft::io {

/// A patch that is there in a frame, if only in part.
struct TrajectoryPatch {
  int patch = 0;  ///< of HandTrajectory::patch_names
  double presence = 1.0;
  double mean_mm = 0.0;
  double normal_deg = 0.0;
  bool reached = false;
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();  ///< its middle on the object
};

struct TrajectoryFrame {
  double time_s = 0.0;
  hand::HandPose pose_W;
  Pose X_WO = Pose::Identity();
  quality::Depths depths;
  /// One may be there twice: on its way out, and in again.
  std::vector<TrajectoryPatch> patches;
};

struct HandTrajectory {
  std::string hand;  ///< names, for people
  std::string object;
  std::string motion;
  std::shared_ptr<const hand::HandModel> model;
  std::shared_ptr<const geometry::TriangleMesh> object_O;
  std::vector<std::string> patch_names;
  std::vector<TrajectoryFrame> frames;  ///< one at least, times rise
  std::vector<std::string> notes;
};

/// `handgraft-trajectory/1`. Cost of all of these: O(frames).
std::string trajectoryJson(const HandTrajectory& trajectory);

/// A line a frame: `time_s`, a column a joint (independent ones, then those that mimic them),
/// `X_WH.x` to `X_WH.qz`, `X_WO.x` to `X_WO.qz`, `max_depth_m`, `self_depth_m`.
std::string trajectoryCsv(const HandTrajectory& trajectory);

/// Binary glTF 2.0 as glbBytes writes a grasp, with an animation that moves every link and the
/// object, linear from frame to frame.
std::string trajectoryGlb(const HandTrajectory& trajectory);

/// As npzOf (row_writer.h).
std::string trajectoryNpz(const HandTrajectory& trajectory);

/// As mjcfOf: keyframes `frame_0`, ...
std::string trajectoryMjcf(const HandTrajectory& trajectory);

/// As that of its rows.
std::string rosTrajectoryYaml(const HandTrajectory& trajectory);

}  // namespace handgraft::io
