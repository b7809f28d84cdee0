#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/io/posed_grasp.h"
#include "core/io/trajectory_writer.h"

namespace handgraft::io {

/// A trajectory as numbers.
struct TrajectoryRows {
  std::vector<std::string> joint_names;  ///< independent ones, then those that mimic them
  int independent = 0;
  std::vector<double> time_s;  ///< from the motion's begin
  /// A column a frame: the root in W (x y z, qw qx qy qz), the joints, the object in W. No
  /// quaternion flips its sign from one frame to the next.
  Eigen::MatrixXd qpos;
  /// A column a frame: the root's linear velocity in W and its angular one in its own frame, as
  /// MuJoCo has them, the joints', the object's. By central differences, one-sided at the ends;
  /// 0 of a single frame.
  Eigen::MatrixXd qvel;
};

/// Cost: O(frames).
TrajectoryRows rowsOf(const HandTrajectory& trajectory);

/// A single row, at rest.
TrajectoryRows rowsOf(const PosedGrasp& grasp);

}  // namespace handgraft::io
