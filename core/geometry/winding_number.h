#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "core/geometry/triangle_mesh.h"

namespace handgraft::geometry {

/// How often a surface winds round a point: 1 inside a closed surface, 0 outside, 2 where two
/// solids overlap, a fraction near the holes of an open one.
///
/// Pieces that are closed count nothing outside their boxes. Other groups of faces farther away
/// than twice their size count as one dipole, which leaves an error of a few hundredths.
/// Const and safe from several threads. Source: Barill et al. 2018, "Fast winding numbers for
/// soups and clouds", first order; van Oosterom & Strackee 1983 for single faces.
class WindingNumber {
 public:
  /// Cost: O(F log F).
  explicit WindingNumber(const TriangleMesh& mesh);

  /// Cost: O(log F).
  [[nodiscard]] double at(const Eigen::Vector3d& p) const;

 private:
  /// Children stand behind: the left one next to it.
  struct Node {
    int begin = 0;  ///< of a leaf's faces, by fours; while building: of all, one by one
    int end = 0;
    int right = -1;
    bool is_closed = false;   ///< made of whole pieces that have no border
    Eigen::AlignedBox3d box;  ///< around the faces, where they are closed
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    Eigen::Vector3d dipole = Eigen::Vector3d::Zero();  ///< sum of area times normal
    double radius = 0.0;
  };

  /// Faces that hang together by vertices.
  struct Piece {
    std::vector<Eigen::Matrix3d> corners;
    Eigen::AlignedBox3d box;
    bool is_closed = true;  ///< every edge has two faces that agree
  };

  using Corners = std::vector<Eigen::Matrix3d>;  ///< of each face, as columns

  /// Four faces side by side.
  struct Four {
    double at[3][3][4];  ///< a corner's coordinate
  };

  struct Angles;

  static std::vector<Piece> piecesOf(const TriangleMesh& mesh);
  /// Of the pieces [begin, end), whose faces become the next ones of `corners`.
  int buildPieces(std::vector<Piece>& pieces, int begin, int end, Corners& corners);
  int build(int begin, int end, Corners& corners);
  static void measure(const Corners& corners, Node& node);
  static Four fourOf(const Corners& corners, int begin, int end);
  void pack(const Corners& corners);
  static void addHalves(const Four* begin,
                        const Four* end,
                        const Eigen::Vector3d& p,
                        Angles& angles);

  std::vector<Four> fours_;
  std::vector<Node> nodes_;
};

}  // namespace handgraft::geometry
