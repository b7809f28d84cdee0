#include "core/geometry/signed_distance.h"

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
  // Faces that are walls in part are cut into so many pieces along each side: what is left of a
  // wall beside the true surface is as wide as one of them.
  constexpr int kPieces = 8;
  constexpr double kNearCorner = 0.9;
  std::vector<Eigen::Vector3d> corners;
  const auto keep = [&](const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                        const Eigen::Vector3d& c) {
    corners.insert(corners.end(), {a, b, c});
  };
  std::size_t solid_corners = 0;
  for (int f = 0; f < surface().faceCount(); ++f) {
    const Eigen::Vector3i face = surface().face(f);
    const Eigen::Vector3d a = surface().vertex(face[0]);
    const Eigen::Vector3d b = surface().vertex(face[1]);
    const Eigen::Vector3d c = surface().vertex(face[2]);
    if (isSheet(f)) {
      keep(a, b, c);
      continue;
    }
    const Eigen::Vector3d off = reach * surface().faceNormals().col(f);
    const auto isWall = [&](const Eigen::Vector3d& p) {
      return contains(p + off) && contains(p - off);
    };
    const Eigen::Vector3d middle = (a + b + c) / 3.0;
    int walls = isWall(middle) ? 1 : 0;
    for (const Eigen::Vector3d& corner : {a, b, c})
      walls += isWall(middle + kNearCorner * (corner - middle)) ? 1 : 0;
    if (walls == 0) {
      keep(a, b, c);
    } else if (walls < 4) {
      const Eigen::Vector3d u = (b - a) / kPieces;
      const Eigen::Vector3d v = (c - a) / kPieces;
      const auto keepUnlessWall = [&](const Eigen::Vector3d& p, const Eigen::Vector3d& q,
                                      const Eigen::Vector3d& r) {
        if (!isWall((p + q + r) / 3.0)) keep(p, q, r);
      };
      for (int i = 0; i < kPieces; ++i) {
        for (int j = 0; i + j < kPieces; ++j) {
          const Eigen::Vector3d p = a + i * u + j * v;
          keepUnlessWall(p, p + u, p + v);
          if (i + j + 1 < kPieces) keepUnlessWall(p + u, p + u + v, p + v);
        }
      }
    }
    solid_corners = corners.size();
  }
  Eigen::Matrix3Xd vertices(3, std::ssize(corners));
  Eigen::Matrix3Xi faces(3, std::ssize(corners) / 3);
  for (Eigen::Index i = 0; i < vertices.cols(); ++i) {
    vertices.col(i) = corners[static_cast<std::size_t>(i)];
    faces(i % 3, i / 3) = static_cast<int>(i);
  }
  return {TriangleMesh(std::move(vertices), std::move(faces)),
          static_cast<int>(solid_corners / 3), winding_};
}

}  // namespace handgraft::geometry
