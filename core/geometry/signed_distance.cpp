#include "core/geometry/signed_distance.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

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

SignedDistance::SignedDistance(const TriangleMesh& surface,
                               int solid_faces,
                               WindingNumber winding)
    : locator_(surface), solid_faces_(solid_faces), winding_(std::move(winding)) {}

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

SignedDistance SignedDistance::withoutInnerWalls(double reach) const {
  // Near its corners, too: a face may begin within the solid and end outside.
  constexpr double kNearCorner = 0.9;
  std::vector<Eigen::Vector3i> kept;
  int solid_faces = 0;
  for (int f = 0; f < surface().faceCount(); ++f) {
    const Eigen::Vector3i face = surface().face(f);
    const Eigen::Vector3d off = reach * surface().faceNormals().col(f);
    const Eigen::Vector3d middle =
        (surface().vertex(face[0]) + surface().vertex(face[1]) + surface().vertex(face[2])) /
        3.0;
    const auto is_within = [&](const Eigen::Vector3d& p) {
      return contains(p + off) && contains(p - off);
    };
    const bool is_wall =
        !isSheet(f) && is_within(middle) && std::all_of(face.begin(), face.end(), [&](int v) {
          return is_within(middle + kNearCorner * (surface().vertex(v) - middle));
        });
    if (is_wall) continue;
    kept.push_back(face);
    if (!isSheet(f)) ++solid_faces;
  }
  Eigen::Matrix3Xi faces(3, std::ssize(kept));
  for (Eigen::Index i = 0; i < faces.cols(); ++i)
    faces.col(i) = kept[static_cast<std::size_t>(i)];
  return {TriangleMesh(surface().vertices(), std::move(faces)), solid_faces, winding_};
}

}  // namespace handgraft::geometry
