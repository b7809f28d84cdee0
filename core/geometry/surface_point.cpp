#include "core/geometry/surface_point.h"

#include <cmath>

#include "core/base/error.h"

namespace handgraft::geometry {

namespace {

constexpr double kVertexWeight = 1.0 - 1e-9;
constexpr double kWeightSlack = 1e-6;  // files write weights with 7 digits or more

}  // namespace

SurfacePoint surfacePointAtVertex(const TriangleMesh& mesh, int vertex) {
  if (vertex < 0 || vertex >= mesh.vertexCount()) {
    rejectInput("vertex {} does not exist, the mesh has vertices 0 to {}", vertex,
                mesh.vertexCount() - 1);
  }
  if (mesh.outgoingBegin(vertex) == mesh.outgoingEnd(vertex)) {
    rejectInput("vertex {} has no face, a surface point needs one", vertex);
  }
  const int h = *mesh.outgoingBegin(vertex);
  SurfacePoint point;
  point.face = TriangleMesh::faceOf(h);
  point.barycentric[h % 3] = 1.0;
  return point;
}

int vertexAt(const TriangleMesh& mesh, const SurfacePoint& point) {
  for (int corner = 0; corner < 3; ++corner) {
    if (point.barycentric[corner] > kVertexWeight) return mesh.faces()(corner, point.face);
  }
  return -1;
}

void validate(const TriangleMesh& mesh, const SurfacePoint& point, const char* what) {
  if (point.face < 0 || point.face >= mesh.faceCount()) {
    rejectInput("{} is on face {}, the mesh has {} faces (numbered from 0)", what, point.face,
                mesh.faceCount());
  }
  const Eigen::Vector3d& w = point.barycentric;
  if (!w.allFinite() || w.minCoeff() < 0.0 || std::abs(w.sum() - 1.0) > kWeightSlack) {
    rejectInput(
        "{} has barycentric weights ({}, {}, {}), they must not be negative and must "
        "sum to 1",
        what, w[0], w[1], w[2]);
  }
}

Eigen::Vector3d positionOf(const TriangleMesh& mesh, const SurfacePoint& point) {
  const Eigen::Vector3i face = mesh.face(point.face);
  return point.barycentric[0] * mesh.vertex(face[0]) +
         point.barycentric[1] * mesh.vertex(face[1]) +
         point.barycentric[2] * mesh.vertex(face[2]);
}

Eigen::Vector3d normalOf(const TriangleMesh& mesh, const SurfacePoint& point) {
  const Eigen::Vector3i face = mesh.face(point.face);
  const Eigen::Vector3d normal = point.barycentric[0] * mesh.vertexNormals().col(face[0]) +
                                 point.barycentric[1] * mesh.vertexNormals().col(face[1]) +
                                 point.barycentric[2] * mesh.vertexNormals().col(face[2]);
  const double length = normal.norm();
  // Normals that nearly cancel point nowhere in particular; the face's own is better.
  constexpr double kCancelled = 1e-6;
  if (length > kCancelled) return normal / length;
  return mesh.faceNormals().col(point.face);
}

}  // namespace handgraft::geometry
