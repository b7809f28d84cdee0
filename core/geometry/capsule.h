#pragma once

#include <Eigen/Core>

namespace handgraft::geometry {

/// All places within `radius` of a segment: what a finger's bone is, nearly.
struct Capsule {
  Eigen::Vector3d a = Eigen::Vector3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  double radius = 0.0;
};

/// One that holds all points, along their longest axis; a ball of radius 0 about the origin for
/// none. Shapes: points 3 x N. Cost: O(N).
Capsule capsuleAround(const Eigen::Matrix3Xd& points);

/// The least distance between the segments a b and c d, squared. Either may be a point.
double squaredDistance(const Eigen::Vector3d& a,
                       const Eigen::Vector3d& b,
                       const Eigen::Vector3d& c,
                       const Eigen::Vector3d& d);

}  // namespace handgraft::geometry
