#pragma once

#include <vector>

#include <Eigen/Core>

#include "core/geometry/triangle_mesh.h"

namespace handgraft::geometry {

/// How often a surface winds round a point: 1 inside a closed surface, 0 outside, 2 where two
/// solids overlap, a fraction near the holes of an open one.
///
/// Groups of faces farther away than twice their size count as one dipole, which leaves an
/// error of a few hundredths.
/// Const and safe from several threads. Source: Barill et al. 2018, "Fast winding numbers for
/// soups and clouds", first order; van Oosterom & Strackee 1983 for single faces.
class WindingNumber {
 public:
  /// Cost: O(F log F).
  explicit WindingNumber(const TriangleMesh& mesh);

  /// Cost: O(log F).
  [[nodiscard]] double at(const Eigen::Vector3d& p) const;

 private:
  /// Faces [begin, end) of `corners_`; children stand behind: the left one next to it.
  struct Node {
    int begin = 0;
    int end = 0;
    int right = -1;
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    Eigen::Vector3d dipole = Eigen::Vector3d::Zero();  ///< sum of area times normal
    double radius = 0.0;
  };

  int build(int begin, int end);

  std::vector<Eigen::Matrix3d> corners_;  ///< of each face, as columns
  std::vector<Node> nodes_;
};

}  // namespace handgraft::geometry
