#pragma once

#include <complex>
#include <string>
#include <vector>

#include "core/geometry/triangle_mesh.h"

namespace handgraft::geometry {

/// What keeps an intrinsic Delaunay triangulation from being built there, on one line: a face
/// without area; a vertex whose faces do not form one fan, or bend back on themselves. Empty if
/// nothing does.
std::string defectOfFace(const TriangleMesh& mesh, int face);
std::string defectOfVertex(const TriangleMesh& mesh, int vertex);

/// The surface of a mesh, triangulated anew between the same vertices: edges are straight lines
/// inside the surface, flipped until no triangle's circumcircle holds the opposite vertex. The
/// shape does not change; the cotan weights of inner edges become non-negative.
///
/// Only edge lengths are kept, and for every halfedge the angle at which it leaves its vertex,
/// so that directions at a vertex mean the same before and after the flips. Halfedges are
/// numbered as in TriangleMesh (h = 3 * face + corner), but faces and edges are others, and two
/// vertices may share several edges, or one vertex be both ends of an edge.
///
/// Directions at a vertex are unit complex numbers: angles inside the surface, from the first
/// face's edge on counter-clockwise, rescaled to a full turn (on the surface's edge as they
/// are, unless they exceed it).
///
/// Source: Sharp, Soliman & Crane 2019, "Navigating Intrinsic Triangulations"; Bobenko &
///   Springborn 2007, "A Discrete Laplace-Beltrami Operator for Simplicial Surfaces".
class IntrinsicDelaunay {
 public:
  /// Errors: InvalidInput with the first defect of a face or vertex, or if edges are too long
  /// to be averaged. Cost: O(F) and the flips,
  /// O(F) of them on usual meshes; bounded on any.
  explicit IntrinsicDelaunay(const TriangleMesh& mesh);

  [[nodiscard]] int vertexCount() const { return static_cast<int>(angle_scales_.size()); }

  [[nodiscard]] int faceCount() const { return static_cast<int>(from_.size()) / 3; }

  [[nodiscard]] int halfedgeCount() const { return static_cast<int>(from_.size()); }

  [[nodiscard]] int flipCount() const { return flip_count_; }

  [[nodiscard]] int from(int h) const { return from_[h]; }

  [[nodiscard]] int to(int h) const { return from_[TriangleMesh::next(h)]; }

  /// The opposite halfedge, or -1 on the surface's edge.
  [[nodiscard]] int twin(int h) const { return twins_[h]; }

  /// One halfedge of every edge.
  [[nodiscard]] bool isFirstOfEdge(int h) const { return twin(h) < h; }

  [[nodiscard]] double length(int h) const { return unit_length_ * lengths_[h]; }

  [[nodiscard]] double area(int face) const;
  /// Angle at from(h) inside h's face.
  [[nodiscard]] double cornerAngle(int h) const;
  /// Half the cotangents opposite to h's edge, summed over its faces.
  [[nodiscard]] double cotanWeight(int h) const;
  /// Opposite angles sum to at most pi (or the edge has one face), within rounding.
  [[nodiscard]] bool isDelaunay(int h) const;

  /// Where h leaves from(h); for the way back, where its twin (present or not) leaves to(h).
  [[nodiscard]] std::complex<double> direction(int h) const;
  [[nodiscard]] std::complex<double> directionBack(int h) const;
  /// The same for a halfedge of the mesh itself, `turn` radians further inside its face.
  [[nodiscard]] std::complex<double> meshDirection(int vertex,
                                                   int mesh_halfedge,
                                                   double turn) const;

 private:
  void measureAngles(const TriangleMesh& mesh);
  void flipToDelaunay();
  void flip(int h);
  [[nodiscard]] double cotanOpposite(int h) const;
  [[nodiscard]] std::complex<double> unitAt(int vertex, double angle) const;

  std::vector<int> from_;
  std::vector<int> twins_;
  double unit_length_ = 1.0;          ///< the mesh's mean edge, metres
  std::vector<double> lengths_;       ///< in units of it, so that squares stay in range
  std::vector<double> angles_;        ///< inside the surface, not rescaled
  std::vector<double> mesh_angles_;   ///< of the mesh's own halfedges
  std::vector<double> angle_scales_;  ///< by vertex
  int flip_count_ = 0;
};

}  // namespace handgraft::geometry
