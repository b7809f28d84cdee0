#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/base/progress.h"

namespace handgraft::cloud {

/// Points of an object's surface as a scanner or a file gives them.
struct PointCloud {
  Eigen::Matrix3Xd points_O;  ///< 3 x N, metres
  Eigen::Matrix3Xd
      normals_O;  ///< 3 x N, outward; zero ones are estimated. No column: none given
};

inline constexpr int kFewestPoints = 30;

/// A cloud fit for reconstruction: distinct points of one piece, unit normals that agree.
struct PreparedCloud {
  Eigen::Matrix3Xd points_O;
  Eigen::Matrix3Xd normals_O;
  /// Which side is out is the giver's word; else the side that the whole bulges to.
  bool normals_given = false;
  double spacing_m = 0.0;  ///< mean distance of the six nearest neighbours, over all points
  double gap_m = 0.0;      ///< farther neighbours than this do not belong together
  /// How wide the widest hundredth of the neighbourhoods is against the usual (median) one:
  /// about 2 for a scan, far more for corners of CAD faces.
  double unevenness = 1.0;
  double roughness_m = 0.0;  ///< `roughnessOf` the points
  /// What was merged, thinned, left out, estimated, for the user.
  std::vector<std::string> notes;
};

/// Merges points at one place, thins to `most_points` (the first of each cell of a grid), keeps
/// the piece with the most points, and completes the normals.
///
/// Given normals are taken where nine tenths of neighbours agree; none are taken otherwise.
/// Frames, units: O, metres; any scale works.
/// Errors: InvalidInput if a point is not finite (named), there are fewer than kFewestPoints,
/// or they are (nearly) a line or a plane. Cancelled. Cost: O(N log N), about 0.05 ms a point
/// with normals to estimate.
PreparedCloud prepare(const PointCloud& given, int most_points, const Progress& progress);

/// Indices, rising, of at most `most` points: the first of each cell of a grid. All if there
/// are no more. Cost: O(N).
std::vector<Eigen::Index> evenSelection(const Eigen::Matrix3Xd& points,
                                        int most,
                                        const Progress& progress);

}  // namespace handgraft::cloud
