#include "core/geometry/signed_distance.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/error.h"
#include "core/base/parallel_for.h"

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

void SignedDistance::keepUnlessWall(int face, double reach, Corners& kept) const {
  // Faces that are walls in part are cut into so many pieces along each side: what is left of a
  // wall beside the true surface is as wide as one of them.
  constexpr int kPieces = 8;
  constexpr double kNearCorner = 0.9;
  const Eigen::Vector3i vertices = surface().face(face);
  const Eigen::Vector3d a = surface().vertex(vertices[0]);
  const Eigen::Vector3d b = surface().vertex(vertices[1]);
  const Eigen::Vector3d c = surface().vertex(vertices[2]);
  const Eigen::Vector3d off = reach * surface().faceNormals().col(face);
  const auto is_wall = [&](const Eigen::Vector3d& p) {
    return contains(p + off) && contains(p - off);
  };
  const Eigen::Vector3d middle = (a + b + c) / 3.0;
  int walls = is_wall(middle) ? 1 : 0;
  for (const Eigen::Vector3d& corner : {a, b, c})
    walls += is_wall(middle + kNearCorner * (corner - middle)) ? 1 : 0;
  if (walls == 0) kept.insert(kept.end(), {a, b, c});
  if (walls == 0 || walls == 4) return;
  const Eigen::Vector3d u = (b - a) / kPieces;
  const Eigen::Vector3d v = (c - a) / kPieces;
  const auto keep = [&](const Eigen::Vector3d& p, const Eigen::Vector3d& q,
                        const Eigen::Vector3d& r) {
    if (!is_wall((p + q + r) / 3.0)) kept.insert(kept.end(), {p, q, r});
  };
  for (int i = 0; i < kPieces; ++i) {
    for (int j = 0; i + j < kPieces; ++j) {
      const Eigen::Vector3d p = a + i * u + j * v;
      keep(p, p + u, p + v);
      if (i + j + 1 < kPieces) keep(p + u, p + u + v, p + v);
    }
  }
}

SignedDistance::Corners SignedDistance::outerFaces(double reach) const {
  constexpr int kAtOnce = 256;  // faces
  std::vector<Corners> parts(static_cast<std::size_t>((solid_faces_ + kAtOnce - 1) / kAtOnce));
  parallelFor(static_cast<int>(parts.size()), [&](int part) {
    const int end = std::min((part + 1) * kAtOnce, solid_faces_);
    for (int f = part * kAtOnce; f < end; ++f)
      keepUnlessWall(f, reach, parts[static_cast<std::size_t>(part)]);
  });
  Corners corners;
  for (const Corners& part : parts)
    corners.insert(corners.end(), part.begin(), part.end());
  return corners;
}

SignedDistance SignedDistance::withOuterFaces(const Corners& outer) const {
  HANDGRAFT_REQUIRE(outer.size() % 3 == 0);
  Corners corners = outer;
  for (int f = solid_faces_; f < surface().faceCount(); ++f)
    for (const int v : surface().face(f))
      corners.emplace_back(surface().vertex(v));
  Eigen::Matrix3Xd vertices(3, std::ssize(corners));
  Eigen::Matrix3Xi faces(3, std::ssize(corners) / 3);
  for (Eigen::Index i = 0; i < vertices.cols(); ++i) {
    vertices.col(i) = corners[static_cast<std::size_t>(i)];
    faces(i % 3, i / 3) = static_cast<int>(i);
  }
  return {TriangleMesh(std::move(vertices), std::move(faces)),
          static_cast<int>(outer.size() / 3), winding_};
}

}  // namespace handgraft::geometry
