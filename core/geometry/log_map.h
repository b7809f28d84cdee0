#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "core/geometry/surface_point.h"

namespace handgraft::geometry {

enum class LogMapMethod { kFast };

/// Errors: InvalidInput naming the permitted spellings.
LogMapMethod logMapMethodFrom(std::string_view name);
std::string_view nameOf(LogMapMethod method);

/// Log-map coordinates of a geodesic disk: for each vertex reached, the length and the
/// direction of the shortest path from the source.
///
/// φ is counter-clockwise seen from outside, zero along the direction given. At a vertex source
/// the angles around it are rescaled to sum to 2 pi (pi on the surface's edge stays as it is).
struct LogMap {
  /// Vertices reached, by increasing r.
  std::vector<int> vertices;
  /// Of the whole mesh, indexed by vertex; NaN where not reached. r in metres, phi in (-pi,
  /// pi].
  Eigen::VectorXd r;
  Eigen::VectorXd phi;
  /// Faces whose three corners were all reached, and the face(s) of the source.
  std::vector<int> faces;

  SurfacePoint source;
  double radius = 0.0;
};

/// Log map of `mesh` about `source`, within geodesic distance `radius`.
///
/// Frames: direction in the mesh's frame; its projection onto the source's tangent plane is the
///   x axis (phi = 0). Units: metres, radians.
/// Shapes: r, phi of mesh.vertexCount() entries.
/// Errors: InvalidInput if the source is not on the mesh, the radius is not positive, or the
///   direction is (nearly) parallel to the source's normal.
/// Cost: O(n log n) in the vertices of the disk, plus one O(V) fill; no factorisation.
/// Source: Melvaer & Reimers 2012, "Geodesic Polar Coordinates on Polygonal Meshes" (`kFast`).
LogMap computeLogMap(const TriangleMesh& mesh,
                     const SurfacePoint& source,
                     const Eigen::Vector3d& direction,
                     double radius,
                     LogMapMethod method = LogMapMethod::kFast);

/// Log coordinates (u = r cos phi, v = r sin phi) at a surface point, linear inside its face.
/// NaN if a corner of the face was not reached. The face of the source itself is exact.
Eigen::Vector2d logCoordinates(const TriangleMesh& mesh,
                               const LogMap& map,
                               const SurfacePoint& point);

/// Why log coordinates have no place on the surface.
enum class Unreachable { kSurfaceEdge, kCutLocus, kBeyondRadius };

/// "edge of the surface", "cut locus", "beyond the disk".
std::string_view reasonOf(Unreachable reason);

/// The inverse of a log map, prepared once per map (a grid over the disk's faces in the tangent
/// plane).
class LogMapInverse {
 public:
  LogMapInverse(const TriangleMesh& mesh, const LogMap& map);

  struct Place {
    SurfacePoint point;  ///< valid() tells whether there is one
    Unreachable reason = Unreachable::kBeyondRadius;
    bool folded = false;  ///< several sheets cover the coordinates; the nearest one was taken
  };

  /// Barycentric inside the face that covers `uv_T`; never the nearest vertex, never clamped
  /// (1e-9 of slack at edges). Cost: O(1) expected.
  [[nodiscard]] Place at(const Eigen::Vector2d& uv_T) const;

 private:
  struct Sheet {
    int face;
    Eigen::Matrix<double, 2, 3> corners_T;
    double r_mean;
  };

  [[nodiscard]] std::pair<int, int> cellOf(const Eigen::Vector2d& uv_T) const;

  std::vector<Sheet> sheets_;
  std::vector<std::vector<int>> cells_;
  Eigen::Vector2d origin_T_ = Eigen::Vector2d::Zero();
  double cell_size_ = 0.0;
  int columns_ = 0;
  int rows_ = 0;
  double radius_ = 0.0;
  bool touches_surface_edge_ = false;
};

}  // namespace handgraft::geometry
