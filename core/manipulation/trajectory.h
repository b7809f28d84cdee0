#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/hand/kinematics.h"
#include "core/manipulation/motion_problem.h"

namespace handgraft::manipulation {

/// A hand over time: the answer to a motion.
struct Trajectory {
  std::vector<double> time_s;
  /// In O: X_WH of each entry is X_OH (motion_problem.h).
  std::vector<hand::HandPose> poses;
  std::vector<double> objective;  ///< of each frame, Eq. 2 with what avoids penetration
  std::vector<std::string> notes;
  int evaluations = 0;  ///< of single frames, all in all
};

/// A pose that a frame of a motion might have, in O.
struct FramePose {
  int frame = 0;
  hand::HandPose pose;
};

/// From one pose (share 0) to another (share 1): joints and place along a line, the rotation
/// about one axis.
hand::HandPose poseBetween(const hand::HandPose& from, const hand::HandPose& to, double share);

/// How fast a trajectory goes, of its joints alone: rad or m, over time.
struct Smoothness {
  double max_step = 0.0;  ///< from one frame to the next
  double max_velocity = 0.0;
  double max_acceleration = 0.0;
  double rms_jerk = 0.0;  ///< over joints and frames; of third differences
  /// Of the joint's own limits: 1 stands at it. 0 where there is none.
  double velocity_share = 0.0;
  double acceleration_share = 0.0;
};

Smoothness measureSmoothness(const MotionProblem& problem,
                             const std::vector<hand::HandPose>& poses);

/// How many times its limit a joint's velocity from frame k - 1 to k is, or its acceleration
/// over frames k - 2 to k; the largest one. At most 1: none is beyond. Cost: O(joints).
double limitShareAt(const MotionProblem& problem,
                    const std::vector<hand::HandPose>& poses,
                    std::size_t k);

/// How a frame fits.
struct FrameFit {
  int points = 0;
  double mean_mm = 0.0;     ///< of all pairs whose track is there, fading ones left out
  double normal_deg = 0.0;  ///< mean angle between n_hand and -n_object; of pairs with normals
  int normals = 0;
};

/// Cost: O(pairs of all frames).
std::vector<FrameFit> fitFrames(const MotionProblem& problem,
                                const std::vector<hand::HandPose>& poses);

/// Mean over all pairs of all frames.
FrameFit meanFit(const std::vector<FrameFit>& frames);

}  // namespace handgraft::manipulation
