#include "core/geometry/straight_way.h"

#include <cmath>
#include <limits>

#include "core/geometry/log_map.h"
#include "core/geometry/straightest_geodesic.h"

namespace handgraft::geometry {
namespace {

constexpr int kMostGrowths = 12;  // times 1.5 each: a way 130 times as long as the air line
constexpr int kMostAims = 8;
constexpr double kHit = 1e-9;     // of the way's length: good enough to stop aiming
constexpr double kMissed = 0.25;  // of the way's length: no straight way leads there

/// A log map of a disk that holds `target`, unless that cannot be reached.
LogMap mapHolding(const TriangleMesh& mesh,
                  const SurfacePoint& from,
                  const Eigen::Vector3d& direction,
                  const SurfacePoint& target) {
  const double chord = (positionOf(mesh, target) - positionOf(mesh, from)).norm();
  double radius = 1.2 * chord + 2.0 * mesh.meanEdgeLength();
  std::size_t reached = 0;
  for (int growth = 0;; ++growth) {
    LogMap map = computeLogMap(mesh, from, direction, radius);
    const bool exhausted = growth > 0 && map.vertices.size() == reached;
    if (exhausted || growth == kMostGrowths || logCoordinates(mesh, map, target).allFinite()) {
      return map;
    }
    reached = map.vertices.size();
    radius *= 1.5;
  }
}

}  // namespace

std::optional<StraightWay> straightWayTo(const TriangleMesh& mesh,
                                         const SurfacePoint& from,
                                         const Eigen::Vector3d& direction,
                                         const SurfacePoint& target) {
  validate(mesh, target, "target of a straight way");
  const LogMap map = mapHolding(mesh, from, direction, target);
  const Eigen::Vector2d uv_target = logCoordinates(mesh, map, target);
  if (!uv_target.allFinite()) return std::nullopt;
  const Eigen::Vector3d p_target = positionOf(mesh, target);
  Eigen::Vector2d uv = uv_target;
  StraightWay best;
  best.miss = std::numeric_limits<double>::infinity();
  for (int aim = 0; aim < kMostAims && best.miss > kHit * uv_target.norm(); ++aim) {
    const double heading = std::atan2(uv.y(), uv.x());
    const StraightWalk walk = walkStraight(mesh, from, direction, uv.norm(), heading);
    const double miss = (positionOf(mesh, walk.point) - p_target).norm();
    if (walk.end == WalkEnd::kArrived && miss < best.miss) best = {heading, uv.norm(), miss};
    const Eigen::Vector2d aside = logCoordinates(mesh, map, walk.point) - uv_target;
    if (!aside.allFinite()) break;
    uv -= aside;
  }
  if (!(best.miss <= kMissed * uv_target.norm())) return std::nullopt;
  return best;
}

}  // namespace handgraft::geometry
