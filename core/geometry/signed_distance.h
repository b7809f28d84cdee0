#pragma once

#include <vector>

#include <Eigen/Core>

#include "core/geometry/closed_surface.h"
#include "core/geometry/surface_locator.h"
#include "core/geometry/winding_number.h"

namespace handgraft::geometry {

/// What holes of a mesh are: flaws of it, or ways in.
enum class Holes {
  kShut,          ///< all of them, however wide
  kOpenWideOnes,  ///< those that a finger goes through stay open (kOpening)
};

/// m; a hole wider than that is an opening of the object, and what has one has no inside.
inline constexpr double kOpening = 0.02;

/// Distance to a surface, negative inside the solid that it borders. Exact: nearest triangle.
///
/// Inside is where the surface, its holes shut (closed_surface.h), winds round once or more,
/// either way. So the sign changes on faces alone and the distance is continuous, on any mesh;
/// overlapping solids count as one, cavities whose walls look into them as empty.
/// Sheets (Holes::kOpenWideOnes) have no inside: there the distance is positive on both sides.
/// Limits: those of `closedSurface`; walls between overlapping solids still count as surface
/// (but see `withoutInnerWalls`).
/// Keeps its own copies. Const and safe from several threads.
class SignedDistance {
 public:
  /// Errors: InvalidInput if the mesh has no face with three different corners. Cost: O(F log
  /// F).
  explicit SignedDistance(const TriangleMesh& mesh, Holes holes = Holes::kShut);

  struct Sample {
    double distance = 0.0;
    Eigen::Vector3d nearest = Eigen::Vector3d::Zero();
    /// The distance's, a unit vector; the face's outward normal on the surface itself.
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  };

  /// Frames: that of the mesh. Errors: InvalidInput if `p` is not finite. Cost: O(log F), some
  /// microseconds.
  [[nodiscard]] Sample at(const Eigen::Vector3d& p) const;

  [[nodiscard]] bool contains(const Eigen::Vector3d& p) const;

  /// Without its sign.
  [[nodiscard]] double distance(const Eigen::Vector3d& p) const {
    return locator_.nearest(p).distance;
  }

  /// Whether the surface is that near, and sooner.
  [[nodiscard]] bool isWithin(const Eigen::Vector3d& p, double reach) const {
    return locator_.nearest(p, reach).has_value();
  }

  /// The surface with its holes shut: faces of solids first, then those of sheets.
  [[nodiscard]] const TriangleMesh& surface() const { return locator_.mesh(); }

  /// The same solid without faces that border nothing: those with the inside `reach` off them
  /// on both sides, all over, as where parts of a link stand in each other. What was the way to
  /// such a wall is now the way out. Frames: the mesh's; `reach` in m, positive. Cost: some 50
  /// us a face, on several threads.
  [[nodiscard]] SignedDistance withoutInnerWalls(double reach) const {
    return withOuterFaces(outerFaces(reach));
  }

  using Corners = std::vector<Eigen::Vector3d>;  ///< of faces, three each

  /// Both halves of that: which of the solids' faces are left, in whole or in pieces, and the
  /// solid that has those. Errors of the second: BrokenContract if corners are missing.
  [[nodiscard]] Corners outerFaces(double reach) const;
  [[nodiscard]] SignedDistance withOuterFaces(const Corners& outer) const;

  /// A face of `surface` that borders no solid.
  [[nodiscard]] bool isSheet(int face) const { return face >= solid_faces_; }

 private:
  explicit SignedDistance(const SolidsAndSheets& parts);
  SignedDistance(const TriangleMesh& surface, int solid_faces, WindingNumber winding);

  /// Adds what is left of a solid's face.
  void keepUnlessWall(int face, double reach, Corners& kept) const;

  SurfaceLocator locator_;
  int solid_faces_ = 0;
  WindingNumber winding_;
};

}  // namespace handgraft::geometry
