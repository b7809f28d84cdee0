#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/io/trajectory_rows.h"

/// Rows of numbers for simulators and robots (FORMATS.md): a motion's, or the one of a grasp.
namespace handgraft::io {

/// Where contacts are, a row a frame, as those of the hand.
struct ContactRows {
  std::vector<std::string> patch_names;
  std::vector<double> presence;  ///< in [0, 1], a row one behind the other
  std::vector<double> p_W_m;     ///< x y z of each patch's root, likewise
};

/// NumPy arrays in a zip file that is not compressed: `time`, `qpos`, `qvel`, `contact`,
/// `contact_pos`, `joint_names`, `patch_names`. qpos is MuJoCo's for a hand on a free joint,
/// its joints, and the object on a free joint; qvel likewise.
/// Errors: BrokenContract unless contacts have as many rows. Cost of all of these: O(rows).
std::string npzOf(const TrajectoryRows& rows, const ContactRows& contacts);

/// MuJoCo's keyframes of that qpos, named `KEY_0`, ..., for a model that includes the file.
std::string mjcfOf(const TrajectoryRows& rows,
                   const std::string& title,
                   const std::string& key);

/// `trajectory_msgs/msg/JointTrajectory` as `ros2 topic pub` reads it: independent joints with
/// positions and velocities. The root is no part of that message.
std::string rosTrajectoryYaml(const TrajectoryRows& rows);

/// With `between` between them, nine digits.
std::string numbersOf(const Eigen::Ref<const Eigen::VectorXd>& values, const char* between);

}  // namespace handgraft::io
