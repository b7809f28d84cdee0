#pragma once

#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/cloud/prepared_cloud.h"
#include "core/geometry/triangle_mesh.h"

namespace handgraft::cloud {

enum class Method {
  kAuto,            ///< Poisson where it invents nothing, else the advancing front
  kPoisson,         ///< closed, smooth, near the points
  kAdvancingFront,  ///< through the points, open where they end
};

/// "Poisson", "advancing front".
const char* nameOf(Method method);

struct SurfaceOptions {
  Method method = Method::kAuto;
  int most_points = 100'000;  ///< more are thinned; at least kFewestPoints
  /// A place of the surface farther from all points than this many spacings is invented, a
  /// point so far from the surface is lost.
  double far_spacings = 3.0;
};

/// A surface laid through a cloud, and how true to it.
struct CloudSurface {
  /// One piece, faces outward, manifold; vertices all have faces.
  geometry::TriangleMesh mesh_O;
  Method method = Method::kPoisson;  ///< which one made it
  int point_count = 0;               ///< points that it was made of
  double spacing_m = 0.0;            ///< of neighbours, on average
  // Distances of these points from the surface.
  double mean_m = 0.0;
  double rms_m = 0.0;
  double max_m = 0.0;
  double astray_share = 0.0;    ///< of the points that are farther than a spacing
  double lost_share = 0.0;      ///< of the points that are farther than `far_spacings`
  double invented_share = 0.0;  ///< of the area that is farther than that from all points
  double reach_m = 0.0;         ///< from its farthest place to the nearest point
  int hole_count = 0;           ///< borders; 0 where it is closed
  double widest_hole_m = 0.0;
  int handle_count = 0;  ///< a mug has one, scissors two or more
  /// All of the above, what was done to the points, and, in words that begin with "check",
  /// what makes the surface doubtful; for the user.
  std::vector<std::string> notes;
};

/// The object's surface from points on it.
///
/// kAuto joins clean points, whose surface is then exact at them, if that closes it: it keeps
/// thin parts and handles. Otherwise it takes Poisson's surface, which evens out noise, if that
/// is closed, loses at most 0.1 % of the points and at most 2 % of it is invented. Otherwise
/// the cloud is an open scan, or thinner than it is dense, and the points are joined. Clean:
/// rougher than a twentieth of the spacing (`roughnessOf`) is noise. Joined points: holes of
/// at most 4 spacings are closed. Poisson fits at most 15,000 points, but is judged by all.
///
/// A closed surface's outside is where its volume is positive; an open one's is where the
/// given normals look, or, without any, where it bulges to. The same points give the same
/// bytes (of Poisson: where they are even, see README). Errors: as `prepare`; InvalidInput if
/// the points give no surface. Cancelled. Cost: about 0.06 ms a point, with Poisson 0.3 ms of
/// the first 15,000 besides.
CloudSurface surfaceOf(const PointCloud& given,
                       const SurfaceOptions& options = {},
                       const Progress& progress = {});

}  // namespace handgraft::cloud
