#include "core/transfer/spine.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/error.h"
#include "core/geometry/straight_way.h"
#include "core/geometry/straightest_geodesic.h"
#include "core/geometry/tangent_direction.h"

namespace handgraft::transfer {
namespace {

using geometry::StraightWalk;
using geometry::SurfacePoint;
using geometry::TriangleMesh;
using geometry::WalkEnd;

constexpr int kMostPieces = 16;  // of one leg

double distanceToSegment(const Eigen::Vector3d& p,
                         const Eigen::Vector3d& a,
                         const Eigen::Vector3d& b) {
  const Eigen::Vector3d ab = b - a;
  const double t = std::clamp(ab.dot(p - a) / ab.squaredNorm(), 0.0, 1.0);
  return (a + t * ab - p).norm();
}

/// About the patch's width: twice the largest distance of its boundary from its axis.
double widthOf(const TriangleMesh& mesh, const contact::Patch& patch) {
  double farthest = 0.0;
  for (const SurfacePoint& point : patch.interpolation_boundary) {
    const Eigen::Vector3d p = positionOf(mesh, point);
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t k = 1; k < patch.axis.size(); ++k) {
      const Eigen::Vector3d a = positionOf(mesh, patch.axis[k - 1]);
      const Eigen::Vector3d b = positionOf(mesh, patch.axis[k]);
      nearest = std::min(nearest, distanceToSegment(p, a, b));
    }
    farthest = std::max(farthest, nearest);
  }
  return 2.0 * farthest;
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
    const Station& start = spine_.stations[from];
    const auto way =
        geometry::straightWayTo(mesh_, start.point, start.direction, patch_.axis[to_knot]);
    if (!way) rejectWay(from_knot, to_knot);
    const bool is_long = way->length > 1.5 * width_;
    const int pieces =
        is_long ? static_cast<int>(std::ceil(std::min(way->length / width_, 1.0 * kMostPieces)))
                : 1;
    // Its turn takes the heading back: the direction is carried along.
    SpineLeg piece{from, way->heading, way->length / pieces, -way->heading};
    for (int i = 0; i < pieces; ++i) {
      piece.from = from;
      const auto station = follow(mesh_, spine_.stations[from], piece);
      if (!station) rejectWay(from_knot, to_knot);
      spine_.stations.push_back(*station);
      spine_.legs.push_back(piece);
      from = static_cast<int>(spine_.legs.size());
    }
    return from;
  }

  [[noreturn]] void rejectWay(int from_knot, int to_knot) const {
    rejectInput("patch {}: no straight way leads along the surface from axis knot {} to {}",
                quoted(patch_.name), from_knot, to_knot);
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
