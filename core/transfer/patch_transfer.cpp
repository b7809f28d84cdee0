#include "core/transfer/patch_transfer.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"

namespace handgraft::transfer {
namespace {

using geometry::LogMap;
using geometry::LogMapMethod;
using geometry::SurfacePoint;
using geometry::TriangleMesh;

constexpr int kMostGrowths = 16;  // times 1.5 each: a disk 650 times as wide as the first

/// The log map of a disk about `source` that holds all `points`, or all of the surface that can
/// be reached.
LogMap logMapAround(const TriangleMesh& mesh,
                    const SurfacePoint& source,
                    const Eigen::Vector3d& direction,
                    const std::vector<SurfacePoint>& points,
                    LogMapMethod method) {
  const Eigen::Vector3d p_source = positionOf(mesh, source);
  double farthest = 0.0;
  double edge = 0.0;
  for (const SurfacePoint& point : points) {
    farthest = std::max(farthest, (positionOf(mesh, point) - p_source).norm());
    const Eigen::Vector3i face = mesh.face(point.face);
    for (int corner = 0; corner < 3; ++corner) {
      const Eigen::Vector3d side =
          mesh.vertex(face[(corner + 1) % 3]) - mesh.vertex(face[corner]);
      edge = std::max(edge, side.norm());
    }
  }
  // A face counts when its three corners do, and the straight way is the shortest that may be.
  double radius = 1.1 * farthest + 1.5 * edge;
  std::size_t reached = 0;
  for (int growth = 0;; ++growth) {
    LogMap map = computeLogMap(mesh, source, direction, radius, method);
    const bool complete =
        std::all_of(points.begin(), points.end(), [&](const SurfacePoint& point) {
          return logCoordinates(mesh, map, point).allFinite();
        });
    const bool exhausted = growth > 0 && map.vertices.size() == reached;
    if (complete || exhausted || growth == kMostGrowths) return map;
    reached = map.vertices.size();
    radius *= 1.5;
  }
}

/// Mean relative change of distances from the root.
class Distortion {
 public:
  void add(double r_hand, double r_object) {
    if (!std::isfinite(r_hand) || !(r_object > 0.0)) return;
    sum_ += std::abs(r_hand / r_object - 1.0);
    ++count_;
  }

  [[nodiscard]] double mean() const { return count_ > 0 ? sum_ / count_ : 0.0; }

 private:
  double sum_ = 0.0;
  int count_ = 0;
};

}  // namespace

void validate(const TransferOptions& options) {
  if (options.interior_rings < 0 || options.interior_rings > kMostInteriorRings) {
    rejectInput("interior rings: {}; permitted are 0 to {}", options.interior_rings,
                kMostInteriorRings);
  }
}

PatchTransfer transferPatch(const TriangleMesh& object_O,
                            const contact::Patch& patch,
                            const hand::Skin& skin,
                            const Placement& placement,
                            const TransferOptions& options) {
  HANDGRAFT_REQUIRE(patch.direction_O.has_value());
  validate(options);
  const LogMapMethod method = options.method;
  validate(object_O, patch);
  validate(skin.mesh(), placement.root_S, "root on the skin");

  // === The patch in its tangent plane, seen from outside the object
  const std::vector<SurfacePoint>& boundary = patch.interpolation_boundary;
  const LogMap map_O = logMapAround(object_O, patch.root, *patch.direction_O, boundary, method);
  std::vector<Eigen::Vector2d> uv_O;
  double farthest = 0.0;
  for (const SurfacePoint& point : boundary) {
    uv_O.push_back(logCoordinates(object_O, map_O, point));
    if (uv_O.back().allFinite()) farthest = std::max(farthest, uv_O.back().norm());
  }

  PatchTransfer transfer;
  transfer.name = patch.name;
  if (!(farthest > 0.0)) {
    for (int i = 0; i < std::ssize(boundary); ++i) {
      transfer.lost.push_back({i, 0, "not connected to the patch's root on the object"});
    }
    return transfer;
  }

  // === Mirrored onto the skin: the hand looks at the object face to face (phi_h = -phi_o)
  // One long edge of slack, so that the faces under the outermost points are whole.
  const double slack = 4.0 * skin.mesh().meanEdgeLength();
  const LogMap map_S = computeLogMap(skin.mesh(), placement.root_S, placement.direction_S,
                                     1.02 * farthest + slack, method);
  const geometry::LogMapInverse inverse_S(skin.mesh(), map_S);
  Distortion distortion;
  for (int i = 0; i < std::ssize(boundary); ++i) {
    if (!uv_O[i].allFinite()) {
      transfer.lost.push_back({i, 0, "not reached from the patch's root on the object"});
      continue;
    }
    const geometry::LogMapInverse::Place place =
        inverse_S.at(Eigen::Vector2d(uv_O[i].x(), -uv_O[i].y()));
    if (!place.point.valid()) {
      transfer.lost.push_back(
          {i, 0, fmt::format("on the skin: {}", geometry::reasonOf(place.reason))});
      continue;
    }
    const Eigen::Vector3d p_S = positionOf(skin.mesh(), place.point);
    const auto on_link = skin.project(p_S, normalOf(skin.mesh(), place.point));
    if (!on_link) {
      transfer.lost.push_back(
          {i, 0, fmt::format("no link within {:.1f} mm of the skin", skin.epsilon() * 1e3)});
      continue;
    }
    const SurfacePoint projected = skin.skinPointOf(on_link->link, on_link->p_L);
    distortion.add(logCoordinates(skin.mesh(), map_S, projected).norm(), uv_O[i].norm());

    Correspondence pair;
    pair.link = on_link->link;
    pair.p_L = on_link->p_L;
    pair.n_L = on_link->n_L;
    pair.p_O = positionOf(object_O, boundary[i]);
    pair.n_O = normalOf(object_O, boundary[i]);
    pair.weight = patch.weight;
    transfer.correspondences.push_back(pair);
    transfer.places_S.push_back(place.point);
    transfer.points_S.push_back(p_S);
  }
  transfer.boundary_count = static_cast<int>(transfer.correspondences.size());
  transfer.method_O = map_O.method;
  transfer.method_S = map_S.method;
  transfer.distance_distortion = distortion.mean();
  return transfer;
}

}  // namespace handgraft::transfer
