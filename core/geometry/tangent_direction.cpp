#include "core/geometry/tangent_direction.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "core/base/error.h"

namespace handgraft::geometry {

namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

/// Axes inside a wedge's face: x towards its `from`, y square to it towards its `to`; zero
/// where the face has no area.
struct WedgeAxes {
  Eigen::Vector3d x;
  Eigen::Vector3d y;
};

WedgeAxes axesOf(const TriangleMesh& mesh, const SourceLayout& layout, int wedge) {
  const int h = layout.wedges[wedge].halfedge;
  WedgeAxes axes;
  axes.x = (mesh.vertex(mesh.from(h)) - layout.origin).stableNormalized();
  const Eigen::Vector3d to = (mesh.vertex(mesh.to(h)) - layout.origin).stableNormalized();
  const Eigen::Vector3d rest = to - to.dot(axes.x) * axes.x;
  constexpr double kFlat = 1e-14;  // sine between the two sides, a few roundings
  axes.y = rest.norm() > kFlat ? Eigen::Vector3d(rest.normalized()) : Eigen::Vector3d::Zero();
  return axes;
}

double azimuth(const Eigen::Vector2d& p) {
  return std::atan2(p.y(), p.x());
}

/// Between a wedge's two sides, 0 to pi (a source on the surface's edge sees half a turn).
double openingOf(const SourceWedge& wedge) {
  const double angle = std::atan2(wedge.from.x() * wedge.to.y() - wedge.from.y() * wedge.to.x(),
                                  wedge.from.dot(wedge.to));
  return angle < -0.5 * std::numbers::pi ? angle + kTurn : std::max(angle, 0.0);
}

/// Wedges of one fan stand one after another; at a face or an edge all are one fan.
bool continues(const TriangleMesh& mesh, const SourceLayout& layout, std::size_t wedge) {
  if (layout.vertex < 0) return true;
  const int out = TriangleMesh::previous(layout.wedges[wedge].halfedge);
  const int in = TriangleMesh::next(layout.wedges[wedge - 1].halfedge);
  return mesh.twin(in) == out;
}

int wedgeIn(const SourceLayout& layout, int face) {
  for (std::size_t w = 0; w < layout.wedges.size(); ++w) {
    if (TriangleMesh::faceOf(layout.wedges[w].halfedge) == face) return static_cast<int>(w);
  }
  HANDGRAFT_REQUIRE(!"a face of the layout");
  return -1;
}

std::pair<int, int> fanAround(const TriangleMesh& mesh, const SourceLayout& layout, int wedge) {
  int first = wedge;
  int last = wedge + 1;
  while (first > 0 && continues(mesh, layout, static_cast<std::size_t>(first)))
    --first;
  while (last < std::ssize(layout.wedges) &&
         continues(mesh, layout, static_cast<std::size_t>(last)))
    ++last;
  return {first, last};
}

}  // namespace

SourceRay rayAt(const TriangleMesh& mesh, const SourceLayout& layout, double phi, int face) {
  const std::pair<int, int> range = fanAround(mesh, layout, wedgeIn(layout, face));
  SourceRay best;
  best.miss = std::numeric_limits<double>::infinity();
  for (int w = range.first; w < range.second; ++w) {
    const SourceWedge& wedge = layout.wedges[w];
    const double start = wedge.base + wedge.scale * azimuth(wedge.from);
    const double angle = std::remainder(phi - start, kTurn) / wedge.scale;
    const double opening = openingOf(wedge);
    const double miss = std::max({-angle, angle - opening, 0.0});
    if (miss < best.miss) best = {w, std::clamp(angle, 0.0, opening), miss};
    if (miss == 0.0) break;
  }
  return best;
}

Eigen::Vector3d directionAlong(const TriangleMesh& mesh,
                               const SourceLayout& layout,
                               const SourceRay& ray) {
  const WedgeAxes axes = axesOf(mesh, layout, ray.wedge);
  return std::cos(ray.angle) * axes.x + std::sin(ray.angle) * axes.y;
}

SourceRay rayAlong(const TriangleMesh& mesh,
                   const SourceLayout& layout,
                   int face,
                   const Eigen::Vector3d& direction) {
  const int wedge = wedgeIn(layout, face);
  const WedgeAxes axes = axesOf(mesh, layout, wedge);
  const double angle = std::atan2(direction.dot(axes.y), direction.dot(axes.x));
  const double opening = openingOf(layout.wedges[wedge]);
  return {wedge, angle, std::max({-angle, angle - opening, 0.0})};
}

double phiOf(const SourceLayout& layout, const SourceRay& ray) {
  const SourceWedge& wedge = layout.wedges[ray.wedge];
  return wedge.base + wedge.scale * (azimuth(wedge.from) + ray.angle);
}

Eigen::Vector3d turnedDirection(const TriangleMesh& mesh,
                                const SurfacePoint& point,
                                const Eigen::Vector3d& direction,
                                double angle) {
  validate(mesh, point, "place of a direction");
  const SourceLayout layout = layOutSource(mesh, point, direction);
  if (layout.vertex < 0) return std::cos(angle) * layout.x + std::sin(angle) * layout.y;
  return directionAlong(mesh, layout, rayAt(mesh, layout, angle, point.face));
}

double angleFromTo(const TriangleMesh& mesh,
                   const SurfacePoint& point,
                   const Eigen::Vector3d& from,
                   const Eigen::Vector3d& to) {
  validate(mesh, point, "place of a direction");
  const SourceLayout layout = layOutSource(mesh, point, from);
  const SourceLayout turned = layOutSource(mesh, point, to);
  if (layout.vertex < 0) return std::atan2(turned.x.dot(layout.y), turned.x.dot(layout.x));
  // The same wedge stands at the same place of the fan, counted from either direction.
  const int wedge = wedgeIn(layout, point.face);
  const double angle =
      std::remainder(layout.wedges[wedge].base - turned.wedges[wedge].base, kTurn);
  return angle > -std::numbers::pi ? angle : std::numbers::pi;
}

}  // namespace handgraft::geometry
