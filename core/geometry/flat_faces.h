#pragma once

#include <array>
#include <limits>
#include <vector>

#include "core/geometry/index_map.h"
#include "core/geometry/triangle_mesh.h"

namespace handgraft::geometry {

/// Faces of a mesh laid flat, each when it is first met. Sides and vertices have numbers of
/// their own, so that memory and time grow with the faces met, not with the mesh.
///
/// Side 3 * i + c is that of the i-th face met which starts at its corner c.
class FlatFaces {
 public:
  /// A side, along x, as one who comes in through it sees the face: from its left end, which is
  /// the halfedge's start, to its right end. One cache line.
  struct alignas(64) Side {
    double length = 0.0;
    double inverse_length = 0.0;  ///< 0 for a side without length
    double apex_x = 0.0;          ///< the opposite corner
    double apex_y = 0.0;
    /// Chen & Han's split: the way through this side that serves the apex best, and where it
    /// crosses the side.
    double split_distance = std::numeric_limits<double>::infinity();
    double split_at = 0.0;
    int across = kNotMet;  ///< the same side of the next face
    int apex = -1;         ///< number of the opposite corner
    int passes = 0;        ///< bundles of paths that came in
  };

  static constexpr int kNotMet = -1;
  static constexpr int kNoFace = -2;

  explicit FlatFaces(const TriangleMesh& mesh) : mesh_(mesh) {
    sides_.reserve(std::size_t{3} * 512);
  }

  /// First side of a face of the mesh. Invalidates references to sides.
  int add(int face);

  /// The side through which the next face is entered, or kNoFace on the surface's edge.
  /// Invalidates references to sides.
  int across(int side) {
    return sides_[side].across != kNotMet ? sides_[side].across : cross(side);
  }

  [[nodiscard]] Side& side(int s) { return sides_[static_cast<std::size_t>(s)]; }

  [[nodiscard]] const Side& side(int s) const { return sides_[static_cast<std::size_t>(s)]; }

  /// Whether paths may go through: there is a face across, and a length.
  [[nodiscard]] bool isOpen(int s) const {
    return side(s).across != kNoFace && side(s).inverse_length > 0.0;
  }

  [[nodiscard]] static int next(int s) { return s % 3 == 2 ? s - 2 : s + 1; }

  [[nodiscard]] static int previous(int s) { return s % 3 == 0 ? s + 2 : s - 1; }

  /// The corner that a side starts at.
  [[nodiscard]] int startOf(int s) const { return side(next(s)).apex; }

  /// The angle at that corner, in radians.
  [[nodiscard]] double cornerAngle(int s) const;

  [[nodiscard]] int halfedgeOf(int s) const { return 3 * faces_.keyOf(s / 3) + s % 3; }

  [[nodiscard]] int sideOf(int halfedge) {
    return add(TriangleMesh::faceOf(halfedge)) + halfedge % 3;
  }

  [[nodiscard]] double longestSide() const { return longest_side_; }

  /// Vertices met are numbered from 0 as they come.
  [[nodiscard]] const IndexMap& vertices() const { return vertices_; }

  /// Number of a vertex of the mesh, a new one if need be.
  int addVertex(int vertex) { return vertices_.add(vertex).first; }

  [[nodiscard]] const TriangleMesh& mesh() const { return mesh_; }

 private:
  int cross(int side);

  const TriangleMesh& mesh_;
  IndexMap vertices_;
  IndexMap faces_;
  std::vector<Side> sides_;
  double longest_side_ = 0.0;
};

}  // namespace handgraft::geometry
