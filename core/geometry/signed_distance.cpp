#include "core/geometry/signed_distance.h"

#include <cmath>
#include <limits>

namespace handgraft::geometry {

namespace {

TriangleMesh solidsOf(const SolidsAndSheets& parts) {
  return {parts.mesh.vertices(), parts.mesh.faces().leftCols(parts.solid_faces)};
}

}  // namespace

SignedDistance::SignedDistance(const TriangleMesh& mesh, Holes holes)
    : SignedDistance(solidsAndSheets(
          mesh, holes == Holes::kShut ? std::numeric_limits<double>::infinity() : kOpening)) {}

SignedDistance::SignedDistance(const SolidsAndSheets& parts)
    : locator_(parts.mesh), solid_faces_(parts.solid_faces), winding_(solidsOf(parts)) {}

bool SignedDistance::contains(const Eigen::Vector3d& p) const {
  return std::abs(winding_.at(p)) > 0.5;
}

SignedDistance::Sample SignedDistance::at(const Eigen::Vector3d& p) const {
  constexpr double kOnSurface = 1e-9;  // m; below it the way to the surface is rounding
  const SurfaceLocator::Hit hit = locator_.nearest(p);
  const double sign = contains(p) ? -1.0 : 1.0;
  Sample sample;
  sample.distance = sign * hit.distance;
  sample.nearest = hit.position;
  sample.gradient = hit.distance > kOnSurface
                        ? Eigen::Vector3d(sign * (p - hit.position) / hit.distance)
                        : Eigen::Vector3d(surface().faceNormals().col(hit.point.face));
  return sample;
}

}  // namespace handgraft::geometry
