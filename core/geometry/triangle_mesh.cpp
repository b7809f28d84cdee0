#include "core/geometry/triangle_mesh.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <utility>

#include "core/base/error.h"

namespace handgraft::geometry {

namespace {

// Sine between two edges of a face below which its normal is rounding noise: coordinates carry
// 1e-16 of their size, and edges of real meshes are down to 1e-4 of it.
constexpr double kFlatSine = 1e-12;

void requireUsable(const Eigen::Matrix3Xd& vertices, const Eigen::Matrix3Xi& faces) {
  constexpr Eigen::Index kMostFaces = std::numeric_limits<int>::max() / 3;
  if (vertices.cols() > std::numeric_limits<int>::max() || faces.cols() > kMostFaces) {
    rejectInput("mesh has {} vertices and {} faces, more than an index holds ({} faces)",
                vertices.cols(), faces.cols(), kMostFaces);
  }
  for (Eigen::Index v = 0; v < vertices.cols(); ++v) {
    if (!vertices.col(v).allFinite()) {
      rejectInput("vertex {} is ({}, {}, {}), coordinates must be finite", v, vertices(0, v),
                  vertices(1, v), vertices(2, v));
    }
  }
  for (Eigen::Index f = 0; f < faces.cols(); ++f) {
    for (int corner = 0; corner < 3; ++corner) {
      const int v = faces(corner, f);
      if (v < 0 || v >= vertices.cols()) {
        rejectInput("face {} names vertex {}, the mesh has vertices 0 to {}", f, v,
                    vertices.cols() - 1);
      }
    }
    const Eigen::Vector3i face = faces.col(f);
    if (face[0] == face[1] || face[1] == face[2] || face[2] == face[0]) {
      rejectInput("face {} is ({}, {}, {}), its three vertices must differ", f, face[0],
                  face[1], face[2]);
    }
  }
}

/// Unit normal of the triangle with edges `a` and `b`; zero if they are parallel or vanish.
Eigen::Vector3d unitNormal(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  // stableNormalized keeps edges of 1e-200 m from underflowing in the cross product.
  const Eigen::Vector3d normal = a.stableNormalized().cross(b.stableNormalized());
  const double sine = normal.norm();
  return sine > kFlatSine ? Eigen::Vector3d(normal / sine) : Eigen::Vector3d::Zero();
}

double cornerAngle(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  const Eigen::Vector3d a_unit = a.stableNormalized();
  const Eigen::Vector3d b_unit = b.stableNormalized();
  return std::atan2(a_unit.cross(b_unit).norm(), a_unit.dot(b_unit));
}

int rootOf(std::vector<int>& parents, int v) {
  while (parents[v] != v) {
    parents[v] = parents[parents[v]];
    v = parents[v];
  }
  return v;
}

}  // namespace

TriangleMesh::TriangleMesh(Eigen::Matrix3Xd vertices, Eigen::Matrix3Xi faces)
    : vertices_(std::move(vertices)), faces_(std::move(faces)) {
  requireUsable(vertices_, faces_);
  buildTwins();
  buildOutgoing();
  buildNormals();
}

void TriangleMesh::buildTwins() {
  const int halfedge_count = 3 * faceCount();
  twins_.assign(static_cast<std::size_t>(halfedge_count), -1);

  // Halfedges of one edge stand side by side once they are sorted by its two vertices: those of
  // each lower one are few.
  std::vector<std::size_t> begins(static_cast<std::size_t>(vertexCount()) + 1, 0);
  const auto low_of = [this](int h) {
    return static_cast<std::size_t>(std::min(from(h), to(h)));
  };
  for (int h = 0; h < halfedge_count; ++h)
    ++begins[low_of(h) + 1];
  std::partial_sum(begins.begin(), begins.end(), begins.begin());
  std::vector<std::pair<int, int>> by_edge(static_cast<std::size_t>(halfedge_count));
  std::vector<std::size_t> cursor(begins.begin(), begins.end() - 1);
  for (int h = 0; h < halfedge_count; ++h)
    by_edge[cursor[low_of(h)]++] = {std::max(from(h), to(h)), h};

  double length_sum = 0.0;
  for (std::size_t low = 0; low + 1 < begins.size(); ++low) {
    const auto last = by_edge.begin() + static_cast<std::ptrdiff_t>(begins[low + 1]);
    auto first = by_edge.begin() + static_cast<std::ptrdiff_t>(begins[low]);
    std::sort(first, last);
    while (first != last) {
      const auto end = std::find_if(first, last, [first](const auto& one) {
        return one.first != first->first;
      });
      const int h = first->second;
      ++edge_count_;
      length_sum += (vertices_.col(to(h)) - vertices_.col(from(h))).norm();
      if (end - first == 2 && from(h) == to((first + 1)->second)) {
        twins_[h] = (first + 1)->second;
        twins_[(first + 1)->second] = h;
      } else if (end - first > 1) {
        ++non_manifold_edges_;
      }
      first = end;
    }
  }
  mean_edge_length_ = edge_count_ > 0 ? length_sum / edge_count_ : 0.0;
}

void TriangleMesh::buildOutgoing() {
  const int halfedge_count = 3 * faceCount();
  offsets_.assign(static_cast<std::size_t>(vertexCount()) + 1, 0);
  for (int h = 0; h < halfedge_count; ++h)
    ++offsets_[from(h) + 1];
  std::partial_sum(offsets_.begin(), offsets_.end(), offsets_.begin());

  outgoing_.resize(static_cast<std::size_t>(halfedge_count));
  std::vector<int> cursor(offsets_.begin(), offsets_.end() - 1);
  for (int h = 0; h < halfedge_count; ++h)
    outgoing_[cursor[from(h)]++] = h;

  boundary_vertex_.assign(static_cast<std::size_t>(vertexCount()), 0);
  for (int h = 0; h < halfedge_count; ++h) {
    if (twin(h) < 0) boundary_vertex_[from(h)] = boundary_vertex_[to(h)] = 1;
  }
}

void TriangleMesh::buildNormals() {
  face_normals_.setZero(3, faceCount());
  vertex_normals_.setZero(3, vertexCount());
  angle_sums_.setZero(vertexCount());
  for (int f = 0; f < faceCount(); ++f) {
    const Eigen::Vector3d corners[3] = {vertex(faces_(0, f)), vertex(faces_(1, f)),
                                        vertex(faces_(2, f))};
    const Eigen::Vector3d normal = unitNormal(corners[1] - corners[0], corners[2] - corners[0]);
    face_normals_.col(f) = normal;
    for (int c = 0; c < 3; ++c) {
      const double angle =
          cornerAngle(corners[(c + 1) % 3] - corners[c], corners[(c + 2) % 3] - corners[c]);
      angle_sums_[faces_(c, f)] += angle;
      vertex_normals_.col(faces_(c, f)) += angle * normal;
    }
  }
  for (int v = 0; v < vertexCount(); ++v) {
    const double length = vertex_normals_.col(v).norm();
    if (length > kFlatSine) {
      vertex_normals_.col(v) /= length;
    } else {
      vertex_normals_.col(v).setZero();
    }
  }
}

bool TriangleMesh::isClosed() const {
  return faceCount() > 0 && std::all_of(twins_.begin(), twins_.end(), [](int twin) {
           return twin >= 0;
         });
}

std::pair<std::vector<int>, int> TriangleMesh::components() const {
  std::vector<int> parents(static_cast<std::size_t>(vertexCount()));
  std::iota(parents.begin(), parents.end(), 0);
  for (int f = 0; f < faceCount(); ++f) {
    for (int c = 1; c < 3; ++c) {
      const int a = rootOf(parents, faces_(0, f));
      const int b = rootOf(parents, faces_(c, f));
      parents[std::max(a, b)] = std::min(a, b);
    }
  }
  // The root is the component's lowest vertex, so numbers rise with the first vertex.
  std::vector<int> numbers(parents.size(), -1);
  int count = 0;
  for (int v = 0; v < vertexCount(); ++v) {
    const int root = rootOf(parents, v);
    if (root == v) numbers[v] = count++;
    numbers[v] = numbers[root];
  }
  return {std::move(numbers), count};
}

int TriangleMesh::eulerCharacteristic() const {
  int used = 0;
  for (int v = 0; v < vertexCount(); ++v)
    used += outgoingBegin(v) != outgoingEnd(v) ? 1 : 0;
  return used - edge_count_ + faceCount();
}

double TriangleMesh::area() const {
  double sum = 0.0;
  for (int f = 0; f < faceCount(); ++f) {
    const Eigen::Vector3d a = vertex(faces_(0, f));
    sum += (vertex(faces_(1, f)) - a).cross(vertex(faces_(2, f)) - a).norm() / 2.0;
  }
  return sum;
}

double TriangleMesh::meanEdgeLength() const {
  return mean_edge_length_;
}

double TriangleMesh::diagonal() const {
  if (vertexCount() == 0) return 0.0;
  return (vertices_.rowwise().maxCoeff() - vertices_.rowwise().minCoeff()).norm();
}

TriangleMesh merged(const std::vector<TriangleMesh>& meshes) {
  Eigen::Index vertex_count = 0;
  Eigen::Index face_count = 0;
  for (const TriangleMesh& mesh : meshes) {
    vertex_count += mesh.vertices().cols();
    face_count += mesh.faces().cols();
  }
  if (vertex_count > std::numeric_limits<int>::max()) {
    rejectInput("merged mesh has {} vertices, at most {} are permitted", vertex_count,
                std::numeric_limits<int>::max());
  }
  Eigen::Matrix3Xd vertices(3, vertex_count);
  Eigen::Matrix3Xi faces(3, face_count);
  Eigen::Index first_vertex = 0;
  Eigen::Index first_face = 0;
  for (const TriangleMesh& mesh : meshes) {
    vertices.middleCols(first_vertex, mesh.vertexCount()) = mesh.vertices();
    faces.middleCols(first_face, mesh.faceCount()) =
        mesh.faces().array() + static_cast<int>(first_vertex);
    first_vertex += mesh.vertexCount();
    first_face += mesh.faceCount();
  }
  return {std::move(vertices), std::move(faces)};
}

TriangleMesh transformed(const TriangleMesh& mesh, const Eigen::Affine3d& X) {
  Eigen::Matrix3Xd vertices = (X.linear() * mesh.vertices()).colwise() + X.translation();
  Eigen::Matrix3Xi faces = mesh.faces();
  if (X.linear().determinant() < 0.0) faces.row(1).swap(faces.row(2));
  return {std::move(vertices), std::move(faces)};
}

}  // namespace handgraft::geometry
