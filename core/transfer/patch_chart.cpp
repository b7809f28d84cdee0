#include "core/transfer/patch_chart.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/error.h"
#include "core/transfer/disk_around.h"

namespace handgraft::transfer {
namespace {

using geometry::LogMap;
using geometry::LogMapInverse;
using geometry::SurfacePoint;
using geometry::TriangleMesh;

constexpr int kFidelityRings = 3;
// Through the air a station that bends away may seem nearer than it is along the surface.
constexpr double kNearlyNearest = 1.5;

bool same(const SurfacePoint& a, const SurfacePoint& b) {
  return a.face == b.face && a.barycentric == b.barycentric;
}

std::vector<SurfacePoint> placesOf(const contact::Patch& patch) {
  std::vector<SurfacePoint> places = patch.interpolation_boundary;
  places.insert(places.end(), patch.axis.begin(), patch.axis.end());
  return places;
}

/// For each station the boundary points that may be nearest to it.
std::vector<std::vector<SurfacePoint>> targetsOf(const TriangleMesh& mesh,
                                                 const std::vector<Station>& stations,
                                                 const std::vector<SurfacePoint>& boundary) {
  std::vector<std::vector<SurfacePoint>> targets(stations.size());
  for (const SurfacePoint& point : boundary) {
    const Eigen::Vector3d p = positionOf(mesh, point);
    std::vector<double> distances;
    for (const Station& station : stations)
      distances.push_back((positionOf(mesh, station.point) - p).norm());
    const double nearest = *std::min_element(distances.begin(), distances.end());
    for (std::size_t s = 0; s < stations.size(); ++s) {
      if (distances[s] <= kNearlyNearest * nearest) targets[s].push_back(point);
    }
  }
  return targets;
}

/// A point on a mesh, not yet measured.
ChartPoint chartPointAt(const TriangleMesh& mesh, const SurfacePoint& place) {
  ChartPoint point;
  point.p_O = positionOf(mesh, place);
  point.n_O = normalOf(mesh, place);
  return point;
}

}  // namespace

PatchChart::PatchChart(std::shared_ptr<const geometry::LogMapper> object_O,
                       const contact::Patch& patch,
                       const TransferOptions& options)
    : object_O_(std::move(object_O)),
      root_(patch.root),
      places_(placesOf(patch)),
      options_(options) {
  HANDGRAFT_REQUIRE(patch.direction_O.has_value());
  const TriangleMesh& mesh = object_O_->mesh();
  validate(options);
  validate(mesh, patch);
  const geometry::ReferenceAxis axis =
      geometry::referenceAxis(mesh, patch.root, *patch.direction_O);
  spine_ = spineOf(mesh, patch, axis.direction);
  const std::vector<std::vector<SurfacePoint>> targets =
      targetsOf(mesh, spine_.stations, patch.interpolation_boundary);
  std::vector<LogMap> maps;
  for (std::size_t s = 0; s < spine_.stations.size(); ++s) {
    const Station& station = spine_.stations[s];
    maps.push_back(
        diskAround(*object_O_, station.point, station.direction, targets[s], options.method));
  }
  method_ = maps.front().method;
  for (const SurfacePoint& place : patch.interpolation_boundary)
    boundary_.push_back(chartPointAt(mesh, place));
  measure(maps);
  drawRings(maps, options.interior_rings);
}

bool PatchChart::answers(const geometry::LogMapper& object_O,
                         const contact::Patch& patch,
                         const TransferOptions& options) const {
  if (&object_O != object_O_.get() || options.method != options_.method ||
      options.interior_rings != options_.interior_rings || !same(patch.root, root_)) {
    return false;
  }
  const std::vector<SurfacePoint> places = placesOf(patch);
  if (patch.interpolation_boundary.size() != boundary_.size() ||
      !std::equal(places.begin(), places.end(), places_.begin(), places_.end(), same)) {
    return false;
  }
  return geometry::referenceAxis(object_O_->mesh(), root_, *patch.direction_O).direction ==
         spine_.stations.front().direction;
}

double PatchChart::directionAngle(const Eigen::Vector3d& direction_O) const {
  return geometry::referenceAxis(object_O_->mesh(), root_, direction_O).angle;
}

/// Every boundary point from the station that it is nearest to.
void PatchChart::measure(const std::vector<LogMap>& maps) {
  const TriangleMesh& mesh = object_O_->mesh();
  reaches_.assign(maps.size(), 0.0);
  for (std::size_t i = 0; i < boundary_.size(); ++i) {
    ChartPoint& point = boundary_[i];
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t s = 0; s < maps.size(); ++s) {
      const Eigen::Vector2d uv_T = logCoordinates(mesh, maps[s], places_[i]);
      if (!(uv_T.norm() < nearest)) continue;  // NaN fails, too
      nearest = uv_T.norm();
      point.station = static_cast<int>(s);
      point.uv_T = uv_T;
    }
    if (point.station < 0) continue;
    double& reach = reaches_[static_cast<std::size_t>(point.station)];
    reach = std::max(reach, nearest);
  }
}

void PatchChart::drawRings(const std::vector<LogMap>& maps, int interior_rings) {
  const TriangleMesh& mesh = object_O_->mesh();
  std::vector<LogMapInverse> inverses;
  inverses.reserve(maps.size());
  for (const LogMap& map : maps)
    inverses.emplace_back(mesh, map);
  const auto draw = [&](double share) {
    ChartRing ring{share, {}};
    for (const ChartPoint& outer : boundary_) {
      ChartPoint point;
      if (outer.station >= 0) {
        const Eigen::Vector2d uv_T = share * outer.uv_T;
        const auto place = inverses[static_cast<std::size_t>(outer.station)].at(uv_T);
        if (place.point.valid()) {
          point = chartPointAt(mesh, place.point);
          point.station = outer.station;
          point.uv_T = uv_T;
          point.folded = place.folded;
        }
      }
      ring.points.push_back(point);
    }
    return ring;
  };
  for (int k = 1; k <= kFidelityRings; ++k)
    fidelity_rings_.push_back(draw(static_cast<double>(k) / (kFidelityRings + 1)));
  for (int k = 1; k <= interior_rings; ++k)
    interior_rings_.push_back(draw(static_cast<double>(k) / (interior_rings + 1)));
}

}  // namespace handgraft::transfer
