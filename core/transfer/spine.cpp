#include "core/transfer/spine.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/error.h"
#include "core/geometry/log_map.h"
#include "core/geometry/straightest_geodesic.h"
#include "core/geometry/tangent_direction.h"

namespace handgraft::transfer {
namespace {

using geometry::LogMap;
using geometry::StraightWalk;
using geometry::SurfacePoint;
using geometry::TriangleMesh;
using geometry::WalkEnd;

constexpr int kMostGrowths = 12;  // times 1.5 each: a way 130 times as long as the air line
constexpr int kMostAims = 8;
constexpr double kHit = 1e-9;     // of the way's length: good enough to stop aiming
constexpr double kMissed = 0.25;  // of the way's length: no straight way leads there
constexpr int kMostPieces = 16;   // of one leg
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

double distanceToSegment(const Eigen::Vector3d& p,
                         const Eigen::Vector3d& a,
                         const Eigen::Vector3d& b) {
  const Eigen::Vector3d ab = b - a;
  const double t = std::clamp(ab.dot(p - a) / ab.squaredNorm(), 0.0, 1.0);
  return (a + t * ab - p).norm();
}

/// About the patch's width: twice the mean distance of its boundary from its axis.
double widthOf(const TriangleMesh& mesh, const contact::Patch& patch) {
  double sum = 0.0;
  for (const SurfacePoint& point : patch.interpolation_boundary) {
    const Eigen::Vector3d p = positionOf(mesh, point);
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t k = 1; k < patch.axis.size(); ++k) {
      const Eigen::Vector3d a = positionOf(mesh, patch.axis[k - 1]);
      const Eigen::Vector3d b = positionOf(mesh, patch.axis[k]);
      nearest = std::min(nearest, distanceToSegment(p, a, b));
    }
    sum += nearest;
  }
  return 2.0 * sum / static_cast<double>(patch.interpolation_boundary.size());
}

/// Log coordinates of `target` about `station`, in a disk large enough to hold it; NaN if there
/// is none.
Eigen::Vector2d coordinatesOf(const TriangleMesh& mesh,
                              const Station& station,
                              const SurfacePoint& target,
                              LogMap& map) {
  const double chord = (positionOf(mesh, target) - positionOf(mesh, station.point)).norm();
  double radius = 1.2 * chord + 2.0 * mesh.meanEdgeLength();
  std::size_t reached = 0;
  for (int growth = 0; growth < kMostGrowths; ++growth) {
    map = computeLogMap(mesh, station.point, station.direction, radius);
    const Eigen::Vector2d uv = logCoordinates(mesh, map, target);
    if (uv.allFinite()) return uv;
    if (growth > 0 && map.vertices.size() == reached) break;
    reached = map.vertices.size();
    radius *= 1.5;
  }
  return {kNaN, kNaN};
}

/// The straight way from `station` to `target`, if there is one; its turn keeps the station's
/// direction.
std::optional<SpineLeg> legTo(const TriangleMesh& mesh,
                              const Station& station,
                              const SurfacePoint& target) {
  LogMap map;
  const Eigen::Vector2d uv_target = coordinatesOf(mesh, station, target, map);
  if (!uv_target.allFinite()) return std::nullopt;
  // Log maps fit: walk there, see by how much it misses, aim anew.
  const Eigen::Vector3d p_target = positionOf(mesh, target);
  Eigen::Vector2d uv = uv_target;
  SpineLeg best;
  double least = std::numeric_limits<double>::infinity();
  for (int aim = 0; aim < kMostAims; ++aim) {
    const double heading = std::atan2(uv.y(), uv.x());
    const StraightWalk walk =
        walkStraight(mesh, station.point, station.direction, uv.norm(), heading);
    const double miss = (positionOf(mesh, walk.point) - p_target).norm();
    if (walk.end == WalkEnd::kArrived && miss < least) {
      least = miss;
      best = {0, heading, uv.norm(), -heading};
    }
    if (least <= kHit * uv_target.norm()) break;
    const Eigen::Vector2d aside = logCoordinates(mesh, map, walk.point) - uv_target;
    if (!aside.allFinite()) break;
    uv -= aside;
  }
  if (!(least <= kMissed * uv_target.norm())) return std::nullopt;
  return best;
}

/// The next station; nothing if the surface ends before.
std::optional<Station> follow(const TriangleMesh& mesh,
                              const Station& station,
                              const SpineLeg& leg) {
  const StraightWalk walk =
      walkStraight(mesh, station.point, station.direction, leg.length, leg.heading);
  if (walk.end != WalkEnd::kArrived) return std::nullopt;
  return Station{walk.point, turnedDirection(mesh, walk.point, walk.direction, leg.turn)};
}

class SpineBuilder {
 public:
  SpineBuilder(const TriangleMesh& mesh, const contact::Patch& patch, double width)
      : mesh_(mesh), patch_(patch), width_(width) {}

  Spine build(const Eigen::Vector3d& direction) {
    const int root = rootKnotOf(mesh_, patch_);
    HANDGRAFT_REQUIRE(root >= 0);
    spine_.stations.push_back({patch_.root, direction});
    int from = 0;
    for (int k = root + 1; k < std::ssize(patch_.axis); ++k)
      from = addWay(from, k - 1, k);
    from = 0;
    for (int k = root - 1; k >= 0; --k)
      from = addWay(from, k + 1, k);
    return std::move(spine_);
  }

 private:
  /// Stations from knot to knot, as many as the way is long; the last one's index.
  int addWay(int from, int from_knot, int to_knot) {
    const auto leg = legTo(mesh_, spine_.stations[from], patch_.axis[to_knot]);
    if (!leg) {
      rejectInput("patch {}: no straight way leads along the surface from axis knot {} to {}",
                  quoted(patch_.name), from_knot, to_knot);
    }
    int pieces = 1;
    if (leg->length > 1.5 * width_) {
      pieces = static_cast<int>(std::ceil(std::min(leg->length / width_, 1.0 * kMostPieces)));
    }
    SpineLeg piece = *leg;
    piece.length /= pieces;
    for (int i = 0; i < pieces; ++i) {
      piece.from = from;
      const auto station = follow(mesh_, spine_.stations[from], piece);
      HANDGRAFT_REQUIRE(station.has_value());  // the whole leg was walked before
      spine_.stations.push_back(*station);
      spine_.legs.push_back(piece);
      from = static_cast<int>(spine_.legs.size());
    }
    return from;
  }

  const TriangleMesh& mesh_;
  const contact::Patch& patch_;
  double width_;
  Spine spine_;
};

}  // namespace

Spine spineOf(const TriangleMesh& object_O,
              const contact::Patch& patch,
              const Eigen::Vector3d& direction_O) {
  if (patch.axis.empty()) return {{{patch.root, direction_O}}, {}};
  return SpineBuilder(object_O, patch, widthOf(object_O, patch)).build(direction_O);
}

std::vector<SpineLeg> turnedLegs(std::vector<SpineLeg> legs, double angle) {
  for (SpineLeg& leg : legs) {
    leg.heading -= angle;
    leg.turn += angle;
  }
  return legs;
}

std::vector<std::optional<Station>> retraceMirrored(const TriangleMesh& skin_S,
                                                    const Station& root_S,
                                                    const std::vector<SpineLeg>& legs) {
  std::vector<std::optional<Station>> stations{root_S};
  for (const SpineLeg& leg : legs) {
    HANDGRAFT_REQUIRE(leg.from >= 0 && leg.from < std::ssize(stations));
    const auto& from = stations[leg.from];
    const SpineLeg mirrored{leg.from, -leg.heading, leg.length, -leg.turn};
    stations.push_back(from ? follow(skin_S, *from, mirrored) : std::nullopt);
  }
  return stations;
}

}  // namespace handgraft::transfer
