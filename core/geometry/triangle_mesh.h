#pragma once

#include <utility>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace handgraft::geometry {

/// An indexed triangle mesh with its connectivity, immutable once built.
///
/// A halfedge h = 3 * face + corner runs from corner `corner` of its face to the next one.
/// Faces are counter-clockwise seen from outside. Non-manifold edges (more than two faces, or
/// two faces of opposite orientation) have no twins: walking treats them as the surface's edge.
class TriangleMesh {
 public:
  TriangleMesh() = default;

  /// Shapes: vertices 3 x V in metres, faces 3 x F of vertex indices.
  /// Errors: InvalidInput on a non-finite vertex (named by its index), an index out of range,
  /// or a face that names one vertex twice. Vertices without a face are allowed. Cost: O(V + F
  /// log F) at most.
  TriangleMesh(Eigen::Matrix3Xd vertices, Eigen::Matrix3Xi faces);

  [[nodiscard]] int vertexCount() const { return static_cast<int>(vertices_.cols()); }

  [[nodiscard]] int faceCount() const { return static_cast<int>(faces_.cols()); }

  [[nodiscard]] const Eigen::Matrix3Xd& vertices() const { return vertices_; }

  [[nodiscard]] const Eigen::Matrix3Xi& faces() const { return faces_; }

  [[nodiscard]] Eigen::Vector3d vertex(int v) const { return vertices_.col(v); }

  [[nodiscard]] Eigen::Vector3i face(int f) const { return faces_.col(f); }

  /// Unit normals, 3 x F; zero for a face without area.
  [[nodiscard]] const Eigen::Matrix3Xd& faceNormals() const { return face_normals_; }

  /// Angle-weighted unit normals, 3 x V; zero where no face with area touches the vertex.
  [[nodiscard]] const Eigen::Matrix3Xd& vertexNormals() const { return vertex_normals_; }

  /// Sum of the corners' angles at vertex v, in radians: 2 pi where the surface is
  /// intrinsically flat, less on a bump, more on a saddle.
  [[nodiscard]] double angleSum(int v) const { return angle_sums_[v]; }

  // === Halfedges
  [[nodiscard]] static int faceOf(int h) { return h / 3; }

  [[nodiscard]] static int next(int h) { return h - h % 3 + (h + 1) % 3; }

  [[nodiscard]] static int previous(int h) { return h - h % 3 + (h + 2) % 3; }

  [[nodiscard]] int from(int h) const { return faces_(h % 3, h / 3); }

  [[nodiscard]] int to(int h) const { return from(next(h)); }

  /// The opposite halfedge, or -1 on the surface's edge and on non-manifold edges.
  [[nodiscard]] int twin(int h) const { return twins_[static_cast<std::size_t>(h)]; }

  /// The halfedges that leave vertex v, in no particular order (all fans of a pinched vertex).
  [[nodiscard]] const int* outgoingBegin(int v) const { return outgoing_.data() + offsets_[v]; }

  [[nodiscard]] const int* outgoingEnd(int v) const {
    return outgoing_.data() + offsets_[v + 1];
  }

  [[nodiscard]] bool isBoundaryVertex(int v) const { return boundary_vertex_[v] != 0; }

  /// Edges with more than two faces, or two that disagree on the direction.
  [[nodiscard]] int nonManifoldEdgeCount() const { return non_manifold_edges_; }

  /// Closed: every edge has two faces that agree.
  [[nodiscard]] bool isClosed() const;
  /// Component number of every vertex (by shared faces) and the number of components;
  /// a vertex without faces is a component of its own.
  [[nodiscard]] std::pair<std::vector<int>, int> components() const;
  /// V - E + F, over vertices that have a face.
  [[nodiscard]] int eulerCharacteristic() const;

  [[nodiscard]] double area() const;
  /// Mean length over edges, each counted once; 0 without faces.
  [[nodiscard]] double meanEdgeLength() const;
  /// Diagonal of the bounding box; 0 without vertices.
  [[nodiscard]] double diagonal() const;

 private:
  void buildTwins();
  void buildOutgoing();
  void buildNormals();

  Eigen::Matrix3Xd vertices_;
  Eigen::Matrix3Xi faces_;
  Eigen::Matrix3Xd face_normals_;
  Eigen::Matrix3Xd vertex_normals_;
  std::vector<int> twins_;
  std::vector<int> outgoing_;
  std::vector<int> offsets_{0};
  std::vector<char> boundary_vertex_;
  Eigen::VectorXd angle_sums_;
  int non_manifold_edges_ = 0;
  int edge_count_ = 0;
  double mean_edge_length_ = 0.0;
};

/// All meshes side by side, the indices of each shifted behind those before it. Cost: O(F log
/// F).
TriangleMesh merged(const std::vector<TriangleMesh>& meshes);

/// The mesh moved by `X`, which may hold a uniform or per-axis scale; a mirroring X turns the
/// faces round, so that they still look outwards. Errors: InvalidInput if X is not finite.
TriangleMesh transformed(const TriangleMesh& mesh, const Eigen::Affine3d& X);

// === Primitives, centred at the origin, z along their axis, outward orientation
// Errors: InvalidInput unless sizes are positive and finite.
/// Full edge lengths along x, y, z; 8 vertices, 12 faces.
TriangleMesh makeBox(const Eigen::Vector3d& size_m);
/// Closed, with a vertex in the middle of both caps; 3 to 4096 segments, radius at the
/// vertices.
TriangleMesh makeCylinder(double radius_m, double length_m, int segments = 32);
/// An icosahedron split 0 to 8 times, its vertices on the sphere: 10 * 4^n + 2 of them.
TriangleMesh makeSphere(double radius_m, int subdivisions = 3);

}  // namespace handgraft::geometry
