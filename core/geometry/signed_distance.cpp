#include "core/geometry/signed_distance.h"

#include <cmath>

#include "core/geometry/closed_surface.h"

namespace handgraft::geometry {

SignedDistance::SignedDistance(const TriangleMesh& mesh)
    : locator_(closedSurface(mesh)), winding_(locator_.mesh()) {}

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
