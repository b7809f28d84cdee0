#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/geometry/surface_point.h"
#include "core/geometry/triangle_mesh.h"
#include "core/hand/hand_location.h"

namespace handgraft::contact {

/// One contact area on an object's surface (paper, III-A: PR, PB and IB).
struct Patch {
  /// The part of the hand it belongs to: a site's name (`thumb`, `palm`), or a segment's
  /// (`index_proximal`, hand::placeNamed), with a number behind where there are several.
  std::string name;
  geometry::SurfacePoint root;
  /// Tangent at the root towards the wrist of the hand that touched, in O. Missing where the
  /// source does not tell; then the first solve finds it.
  std::optional<Eigen::Vector3d> direction_O;
  /// Closed simple loop around the patch, counter-clockwise seen from outside, mesh vertices.
  /// Empty if the patch was carried from another mesh, whose edges this one lacks.
  std::vector<int> boundary;
  /// 20-30 places at equal arc length along the boundary.
  std::vector<geometry::SurfacePoint> interpolation_boundary;
  /// Where on the hand that touched it was; missing where the source does not tell.
  std::optional<hand::HandLocation> place;
  /// Multiplies the patch's part of the objective; 0 switches it off.
  double weight = 1.0;
};

inline constexpr int kDefaultInterpolationCount = 25;
inline constexpr int kFewestInterpolationPoints = 3;
inline constexpr int kMostInterpolationPoints = 10'000;
inline constexpr double kLargestWeight = 1e6;

/// `count` places at equal arc length along a closed loop of mesh vertices, starting at its
/// first.
///
/// Errors: InvalidInput if a vertex does not exist, two neighbours of the loop share no edge
/// (named
///   by the pair), the loop has no length, or the count is out of its range.
/// Cost: O(length of the loop + count).
std::vector<geometry::SurfacePoint> sampleLoop(const geometry::TriangleMesh& mesh,
                                               const std::vector<int>& loop,
                                               int count = kDefaultInterpolationCount);

/// Everything a patch promises about its mesh, but for the loop's sense of rotation: a name,
/// places on the mesh, a direction that is not the normal, a simple loop along edges, a weight
/// in range. InvalidInput names the patch and the fault.
void validate(const geometry::TriangleMesh& mesh, const Patch& patch);

}  // namespace handgraft::contact
