#pragma once

#include <vector>

#include <Eigen/Core>

#include "core/contact/patch.h"

namespace handgraft::contact {

/// A patch's outline laid flat about its root, as long as it is in its long direction.
struct PatchShape {
  double length_m = 0.0;
  double width_m = 0.0;  ///< area / length: the mean over the length
  /// The long direction at the root, a unit tangent; towards the end that is farther away.
  Eigen::Vector3d long_direction_O = Eigen::Vector3d::Zero();
};

/// Errors: InvalidInput as validate, or if fewer than 3 boundary points can be reached from the
/// root. Cost: a log map that holds the patch.
PatchShape shapeOf(const geometry::TriangleMesh& mesh, const Patch& patch);

struct AxisOptions {
  double shortest_m = 0.040;  ///< patches no longer than this get no axis
  /// Nor do those whose length is at most so many times their width: all of their points are
  /// then about as near to the root as to any other knot.
  double slenderness = 1.8;
};

/// The middle line of a long patch: the root, and on either side of it the middles of slices
/// across the long direction, a width or less apart, the last ones half a width from the ends.
/// Empty if the patch is not long, has one width beyond the root on neither side, or if no
/// straight way leads along the line.
///
/// The answer is the same for the same mesh, and moves with it. Limits: slices are taken in
/// the log map about the root; of a U they meet both legs, and take the wider.
/// Errors: InvalidInput as shapeOf, or if an option is not above 0. Cost: a log map that holds
///   the patch and one a knot.
std::vector<geometry::SurfacePoint> makeAxis(const geometry::TriangleMesh& mesh,
                                             const Patch& patch,
                                             const AxisOptions& options = {});

}  // namespace handgraft::contact
