#include "core/transfer/patch_chart.h"

#include <algorithm>
#include <cmath>
#include <numbers>
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

bool same(const SurfacePoint& a, const SurfacePoint& b) {
  return a.face == b.face && a.barycentric == b.barycentric;
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
      places_(patch.interpolation_boundary),
      options_(options) {
  HANDGRAFT_REQUIRE(patch.direction_O.has_value());
  const TriangleMesh& mesh = object_O_->mesh();
  validate(options);
  validate(mesh, patch);
  axis_O_ = geometry::referenceAxis(mesh, root_, *patch.direction_O).direction;
  const LogMap map = diskAround(*object_O_, root_, axis_O_, places_, options.method);
  method_ = map.method;
  measure(map);
  drawRings(map);
}

bool PatchChart::answers(const geometry::LogMapper& object_O,
                         const contact::Patch& patch,
                         const TransferOptions& options) const {
  if (&object_O.mesh() != &object_O_->mesh() || options.method != options_.method ||
      options.interior_rings != options_.interior_rings || !same(patch.root, root_)) {
    return false;
  }
  if (!std::equal(places_.begin(), places_.end(), patch.interpolation_boundary.begin(),
                  patch.interpolation_boundary.end(), same)) {
    return false;
  }
  return geometry::referenceAxis(object_O_->mesh(), root_, *patch.direction_O).direction ==
         axis_O_;
}

double PatchChart::directionAngle(const Eigen::Vector3d& direction_O) const {
  return geometry::referenceAxis(object_O_->mesh(), root_, direction_O).angle;
}

bool PatchChart::surroundsRoot() const {
  std::vector<Eigen::Vector2d> loop_T;
  for (const ChartPoint& point : boundary_)
    if (point.reached) loop_T.push_back(point.uv_T);
  constexpr std::size_t kFewest = 3;
  if (loop_T.size() < kFewest) return true;  // nothing is known
  // A slender patch has its root on the outline itself, and few points cut its corners.
  constexpr double kOnIt = 0.003;  // m
  double turned = 0.0;
  for (std::size_t i = 0; i < loop_T.size(); ++i) {
    const Eigen::Vector2d& a = loop_T[i];
    const Eigen::Vector2d& b = loop_T[(i + 1) % loop_T.size()];
    const Eigen::Vector2d way = b - a;
    const double share =
        way.squaredNorm() > 0.0 ? std::clamp(-a.dot(way) / way.squaredNorm(), 0.0, 1.0) : 0.0;
    if ((a + share * way).norm() < kOnIt) return true;
    turned += std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b));
  }
  // A whole turn inside, none outside.
  return std::abs(turned) > std::numbers::pi;
}

void PatchChart::measure(const LogMap& map) {
  const TriangleMesh& mesh = object_O_->mesh();
  for (const SurfacePoint& place : places_) {
    ChartPoint& point = boundary_.emplace_back(chartPointAt(mesh, place));
    const Eigen::Vector2d uv_T = logCoordinates(mesh, map, place);
    point.reached = uv_T.allFinite();
    if (!point.reached) continue;
    point.uv_T = uv_T;
    reach_ = std::max(reach_, uv_T.norm());
  }
}

void PatchChart::drawRings(const LogMap& map) {
  const TriangleMesh& mesh = object_O_->mesh();
  const LogMapInverse inverse(mesh, map);
  const auto draw = [&](double share) {
    ChartRing ring{share, {}};
    for (const ChartPoint& outer : boundary_) {
      ChartPoint point;
      if (outer.reached) {
        const Eigen::Vector2d uv_T = share * outer.uv_T;
        const LogMapInverse::Place place = inverse.at(uv_T);
        if (place.point.valid()) {
          point = chartPointAt(mesh, place.point);
          point.reached = true;
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
  const int interior_rings = options_.interior_rings;
  for (int k = 1; k <= interior_rings; ++k)
    interior_rings_.push_back(draw(static_cast<double>(k) / (interior_rings + 1)));
}

}  // namespace handgraft::transfer
