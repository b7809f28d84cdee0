#pragma once

#include <Eigen/Core>

#include "core/geometry/log_map_source.h"

namespace handgraft::geometry {

// Directions at a place of the surface, and the angles between them as log maps count them:
// counter-clockwise seen from outside; at a vertex inside the faces, rescaled to a full turn
// (README of this folder). A log map made with one direction, its phi less the angle, is the
// log map made with the other.

/// `direction` turned by `angle` (rad). Unit tangent: in the plane T inside a face and on an
/// edge, along one of the faces at a vertex.
///
/// At a vertex on the surface's edge the result may point off the surface: then it is the
/// nearest one that does not. Errors: InvalidInput as layOutSource.
Eigen::Vector3d turnedDirection(const TriangleMesh& mesh,
                                const SurfacePoint& point,
                                const Eigen::Vector3d& direction,
                                double angle);

/// The angle that turns `from` into `to`, in (-pi, pi]. Of a pinched vertex's fans, the one
/// that holds the face of `point` counts. Errors: InvalidInput as layOutSource.
double angleFromTo(const TriangleMesh& mesh,
                   const SurfacePoint& point,
                   const Eigen::Vector3d& from,
                   const Eigen::Vector3d& to);

// === For those who hold a layout

/// A straight way out of the source of a layout, inside one of its faces.
struct SourceRay {
  int wedge = -1;  ///< index into the layout's
  /// From the wedge's `from` towards its `to`, inside the face (rad).
  double angle = 0.0;
  /// How far the wished direction lies beside all faces, on the surface's edge (rad); angle is
  /// then at the wedge's nearest side.
  double miss = 0.0;
};

/// The ray that leaves at `phi`; of a pinched vertex's fans, in the one that holds `face`.
SourceRay rayAt(const TriangleMesh& mesh, const SourceLayout& layout, double phi, int face);

/// Unit tangent of a ray, in the mesh's frame: along the wedge's own face.
Eigen::Vector3d directionAlong(const TriangleMesh& mesh,
                               const SourceLayout& layout,
                               const SourceRay& ray);

/// The ray of a direction that lies in `face`, one of the layout's: inside its wedge (miss 0)
/// or beside it.
SourceRay rayAlong(const TriangleMesh& mesh,
                   const SourceLayout& layout,
                   int face,
                   const Eigen::Vector3d& direction);

/// phi at which a ray leaves.
double phiOf(const SourceLayout& layout, const SourceRay& ray);

}  // namespace handgraft::geometry
