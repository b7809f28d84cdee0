#pragma once

#include <memory>
#include <string>

#include "core/geometry/triangle_mesh.h"
#include "core/manipulation/motion.h"
#include "core/retargeting/motion_solving.h"

/// A hand that follows a motion, for other programs (FORMATS.md).
namespace handgraft::io {

struct HandTrajectory {
  std::string hand;  ///< names, for people
  std::string object;
  std::string motion;
  std::shared_ptr<const hand::HandModel> model;
  std::shared_ptr<const geometry::TriangleMesh> object_O;
  std::shared_ptr<const manipulation::Motion> contacts;
  std::shared_ptr<const retargeting::SolvedMotion> solved;  ///< of that hand and motion
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
