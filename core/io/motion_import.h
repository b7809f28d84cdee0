#pragma once

#include <filesystem>
#include <vector>

#include <Eigen/Core>

#include "core/base/pose.h"
#include "core/geometry/triangle_mesh.h"
#include "core/manipulation/motion.h"

namespace handgraft::io {

/// Splines of a `.smexp` trajectory: JSON of open uniform cubic B-splines, one a degree of
/// freedom, over all frames alike.
struct SplineTrajectory {
  double duration_s = 0.0;
  /// Shapes: control points x degrees of freedom; metres and radians.
  Eigen::MatrixXd controls;

  /// At `share` in [0, 1] of the way; clamped.
  [[nodiscard]] Eigen::VectorXd at(double share) const;
};

/// Errors: InvalidInput naming the file and the field.
SplineTrajectory readSplineTrajectory(const std::filesystem::path& path);

/// The pose that six coordinates of such a file mean: translation, then angles about x, y, z
/// with R = Rz Ry Rx.
Pose poseFromSpline(const Eigen::VectorXd& coordinates);

/// Reads contacts as points over time: JSON with `fps` and `frames`, each of which has
/// `contacts` of `object_point`, `link` and `hand_point` (m); at most a few points a link. A
/// track is a point of one link, matched from frame to frame by where it is on both sides.
///
/// `object_path`: a `.smexp` trajectory of the object; empty: it stands still. Points farther
/// than 1 cm off the object are left out, with a note; so is noted that the path lasts longer
/// or shorter than the recording, in whose time it is followed. Errors: InvalidInput naming the
/// file, the frame and the field.
manipulation::Motion readContactSequence(const std::filesystem::path& path,
                                         const geometry::TriangleMesh& object_O,
                                         const std::filesystem::path& object_path);

/// A pose at a time.
struct TimedPose {
  double time_s = 0.0;
  Pose X_WO = Pose::Identity();
};

/// Keyframes as CSV: `time_s,x,y,z,qw,qx,qy,qz` a line (m), a heading of these names first.
/// Errors: InvalidInput naming the file and the line.
std::vector<TimedPose> readKeyframes(const std::filesystem::path& path);

}  // namespace handgraft::io
