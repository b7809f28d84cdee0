#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "core/geometry/surface_point.h"

namespace handgraft::geometry {

enum class LogMapMethod {
  kFast,    ///< discrete geodesic polar coordinates
  kExact,   ///< the polyhedron's own shortest paths
  kAuto,    ///< exact, unless it folds or halves more faces of the disk than fast does
  kSmooth,  ///< affine heat method
  kHeat     ///< vector heat method, as the paper has it
};

/// Errors: InvalidInput naming the permitted spellings.
LogMapMethod logMapMethodFrom(std::string_view name);
std::string_view nameOf(LogMapMethod method);

/// Log-map coordinates of a geodesic disk: for each vertex reached, the length and the
/// direction of the shortest path from the source.
///
/// phi is counter-clockwise seen from outside, zero along the direction given. At a vertex
/// source the angles around it are rescaled to sum to 2 pi; on the surface's edge they stay as
/// they are.
struct LogMap {
  /// A vertex beyond the radius, corner of a face that the disk reaches into.
  struct RimVertex {
    int vertex = -1;
    Eigen::Vector2d p_T = Eigen::Vector2d::Zero();
  };

  /// Vertices reached, by increasing r.
  std::vector<int> vertices;
  /// Of the whole mesh, indexed by vertex; NaN where not reached. r in metres, phi in (-pi,
  /// pi].
  Eigen::VectorXd r;
  Eigen::VectorXd phi;
  /// Faces whose three corners were all reached, and the face(s) of the source; ascending.
  std::vector<int> faces;
  /// Faces that the disk reaches into with a corner beyond the radius, and those corners, both
  /// ascending: they make coordinates complete up to the radius on coarse meshes.
  std::vector<int> rim_faces;
  std::vector<RimVertex> rim;

  SurfacePoint source;
  double radius = 0.0;
  LogMapMethod method = LogMapMethod::kFast;  ///< that made it, never kAuto
};

/// Log map of `mesh` about `source`, within geodesic distance `radius`.
///
/// Frames: direction in the mesh's frame; its projection onto the source's tangent plane is the
///   x axis (phi = 0). Units: metres, radians.
/// Shapes: r, phi of mesh.vertexCount() entries.
/// Errors: InvalidInput if the source is not on the mesh, the radius is not positive (infinity
///   is permitted), the direction is (nearly) parallel to the source's normal, or `kSmooth` or
///   `kHeat` cannot use the source's component (HeatLogMap).
/// Cost: O(n log n) in the vertices of the disk, plus one O(V + F) fill; no factorisation.
///   `kSmooth` and `kHeat` factor the whole mesh at every call: keep a HeatLogMap for several.
///   `kExact` takes up to twice as long as `kFast`, `kAuto` as both where `kExact` is not
///   sound.
/// Source: Melvaer & Reimers 2012, "Geodesic Polar Coordinates on Polygonal Meshes" (`kFast`);
///   Chen & Han 1990 and Xin & Wang 2009 (`kExact`); HeatLogMap. README of this folder: when to
///   use which.
LogMap computeLogMap(const TriangleMesh& mesh,
                     const SurfacePoint& source,
                     const Eigen::Vector3d& direction,
                     double radius,
                     LogMapMethod method = LogMapMethod::kFast);

/// Log coordinates (u = r cos phi, v = r sin phi) of a vertex reached or on the rim; NaN
/// elsewhere.
Eigen::Vector2d logCoordinatesAtVertex(const LogMap& map, int vertex);

/// Log coordinates at a surface point, linear inside its face, which makes them exact in the
/// face of the source. NaN if a corner that counts was neither reached nor on the rim. Errors:
/// InvalidInput if the point is not on the mesh.
Eigen::Vector2d logCoordinates(const TriangleMesh& mesh,
                               const LogMap& map,
                               const SurfacePoint& point);

/// Why log coordinates have no place on the surface.
enum class Unreachable { kSurfaceEdge, kCutLocus, kBeyondRadius };

/// "edge of the surface", "cut locus", "beyond the disk".
std::string_view reasonOf(Unreachable reason);

/// The inverse of a log map, prepared once per map: a grid over the disk's faces in the tangent
/// plane.
///
/// Faces that straddle the cut locus are no part of it; those that are turned over in the plane
/// are no place, but fold the faces over which they lie.
class LogMapInverse {
 public:
  /// Cost: O(F) expected in the disk's faces. Keeps no reference to mesh or map.
  LogMapInverse(const TriangleMesh& mesh, const LogMap& map);

  struct Place {
    SurfacePoint point;  ///< valid() tells whether there is one
    Unreachable reason = Unreachable::kBeyondRadius;
    /// Several faces cover the coordinates, turned over ones included; of those that are not,
    /// the nearest one was taken.
    bool folded = false;
  };

  /// Barycentric inside the face that covers `uv_T`; never the nearest vertex, never clamped
  /// (1e-9 of slack at edges). Where several faces do, the one whose own distances to the
  /// source are shortest. Without any, the reason is the border at which the straight way from
  /// the source to `uv_T` last leaves the disk. Coordinates that are not finite are beyond the
  /// radius. Cost: O(1) expected; O(border) without a place.
  [[nodiscard]] Place at(const Eigen::Vector2d& uv_T) const;

  /// Log coordinates of a face's corners; nothing of faces that are no place. Cost: O(F).
  [[nodiscard]] std::optional<Eigen::Matrix<double, 2, 3>> cornersOf(int face) const;

 private:
  // Sessions keep an inverse a patch and side: what can be computed again is not kept.
  struct Sheet {
    int face;
    std::array<int, 3> corners;  ///< into `places_T_`
  };

  struct Border {
    int from;  ///< into `places_T_`
    int to;
    Unreachable reason;
  };

  void buildGrid();
  template <class Visit>
  void forCellsOf(const Sheet& sheet, const Visit& visit) const;
  [[nodiscard]] Eigen::Matrix<double, 2, 3> cornersOf(const Sheet& sheet) const;
  [[nodiscard]] int columnOf(double x) const;
  [[nodiscard]] int rowOf(double y) const;
  [[nodiscard]] Unreachable reasonAt(const Eigen::Vector2d& uv_T) const;

  std::vector<Eigen::Vector2d> places_T_;  ///< of vertices
  /// From `turned_over_` on those that are turned over in the plane: no place, but they fold
  /// what they cover.
  std::vector<Sheet> sheets_;
  std::size_t turned_over_ = 0;
  std::vector<Border> borders_;
  /// Sheets of cell c are cell_sheets_[cell_offsets_[c]] to [cell_offsets_[c + 1]].
  std::vector<int> cell_offsets_;
  std::vector<int> cell_sheets_;
  Eigen::Vector2d low_T_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d high_T_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d cell_size_ = Eigen::Vector2d::Ones();
  int columns_ = 0;
  int rows_ = 0;
  double radius_ = 0.0;
};

}  // namespace handgraft::geometry
