#pragma once

#include <vector>

#include <Eigen/Core>

#include "core/contact/region.h"
#include "core/geometry/triangle_mesh.h"

namespace handgraft::contact {

struct OutlineOptions {
  /// Of what the region reaches: contact above this share of it is inside; in [0, 1).
  double share = 0.75;
  double minimum_area_m2 =
      0.0;  ///< less than this is no part; without one the region stays whole
};

/// What of a region in contact really touches. Contact is known through a blur: heat spreads,
/// and a distance turned into contact fades over millimetres beside the finger. So the outline
/// is drawn where contact falls below a share of what the region reaches, that is the value
/// that 5 % of its area exceed. That may leave several parts, as of two fingers whose contact
/// runs together: all that are no smaller than the least area, the one with the most contact
/// first; one at least.
///
/// A rigid finger touches one side of an edge. Round a rim, contact by distance covers both
/// sides, whose points no pose can reach at once: faces that look more than 75 degrees away
/// from where most of the contact looks are left out.
///
/// `even` is `value` with its noise evened out (threshold.h), `areas` those of the vertices;
/// V entries each. What is at the region's own top stays inside, so that a map of yes and no
/// keeps its outline. Cost: O(n log n) in the region.
std::vector<Region> outlined(const geometry::TriangleMesh& mesh,
                             const Region& region,
                             const Eigen::VectorXd& value,
                             const Eigen::VectorXd& even,
                             const Eigen::VectorXd& areas,
                             const OutlineOptions& options);

/// Steps of `smoothed` that make an even map for this: a ring of dents, as deep contact leaves
/// it, must not cut a patch to pieces.
inline constexpr int kOutlineSmoothingSteps = 2;

}  // namespace handgraft::contact
