#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "core/base/pose.h"
#include "core/base/progress.h"
#include "core/contact/contact_map.h"
#include "core/geometry/surface_locator.h"
#include "core/geometry/triangle_mesh.h"
#include "core/geometry/winding_number.h"

namespace handgraft::contact {

/// A part of a hand where its pose puts it.
struct PosedSurface {
  std::string name;               ///< of the link; its finger is found by fingerOfSegment
  geometry::TriangleMesh mesh_O;  ///< faces counter-clockwise seen from outside
};

/// A part of a hand in its own frame, with what many poses of it ask for; one without faces is
/// in reach of nothing. Const and safe from several threads. Cost to make: O(F log F).
class PartSurface {
 public:
  PartSurface(std::string name, const geometry::TriangleMesh& mesh_L);

  [[nodiscard]] const std::string& name() const { return name_; }

  [[nodiscard]] bool hasFaces() const { return locator_.has_value(); }

  /// A ball about all of it; the centre in L.
  [[nodiscard]] Eigen::Vector3d centre() const { return box_L_.center(); }

  [[nodiscard]] double radius() const { return 0.5 * box_L_.diagonal().norm(); }

  /// Distance to the surface; infinity beyond `reach`.
  [[nodiscard]] double distance(const Eigen::Vector3d& p_L, double reach) const;
  /// How far inside; below 0 outside, minus infinity beyond `reach`.
  [[nodiscard]] double depth(const Eigen::Vector3d& p_L, double reach) const;

 private:
  [[nodiscard]] bool contains(const Eigen::Vector3d& p_L) const;

  std::string name_;
  std::optional<geometry::SurfaceLocator> locator_;
  std::optional<geometry::WindingNumber> winding_;
  Eigen::AlignedBox3d box_L_;
};

struct PoseContactOptions {
  /// Distance at which a part no longer touches. Fits of a hand's pose miss the surface by
  /// millimetres on either side.
  double reach_m = 0.010;
  /// Behind the place where a part reaches farthest, contact ends after so much. With what
  /// contact::segment makes of it, a patch ends 1.5 mm behind, as much as a finger's pad gives.
  /// 0: by distance alone, max(0, 1 - d / reach), as DexYCB's maps were made.
  double softness_m = 0.006;
  /// The object's mesh is cut down to edges this long, so that patches have a shape.
  double longest_edge_m = 0.004;
};

/// The contact map of a posed hand by its shape alone, for grasps that were recorded as poses.
///
/// Such poses stand millimetres in the object or off it, and a rigid finger that is sunk deep
/// would touch with all its width. So each part is drawn back, or forth, to the surface: at a
/// vertex s deep in its nearest part (negative outside), of which the deepest is S,
///   contact = min(1, 1 + S / reach) max(0, 1 - (S - s) / softness),
/// which is 1 where the part is deepest, and where it does not reach the object at all less by
/// what it lacks. The label is the part's index, -1 where contact is 0.
///
/// A part need not be closed: inside is where its faces wind around the vertex by more than
/// half. Where parts overlap, the one that holds a vertex deepest has it, of equals the first.
///
/// Frames: all in O, metres. Errors: InvalidInput if an option is out of range, the object or
/// all parts have no face, or no part is within reach: another frame, or a pose that touches
/// nothing (the message says how far the nearest part is). Cancelled on wish. Cost: a
/// nearest-place query per vertex and part within reach, and one of the winding number, to a
/// few hundredths (geometry/winding_number.h), for each vertex in a part's bounding box.
ContactMap contactsFromPose(const geometry::TriangleMesh& object_O,
                            const std::vector<PosedSurface>& parts_O,
                            const PoseContactOptions& options = {},
                            const Progress& progress = Progress());

/// The same on the mesh's own vertices, however far apart they are, with the parts at `X_OL`:
/// for many poses of a hand on an object whose edges were refined once (refineEdges).
ContactMap contactsOnVertices(const geometry::TriangleMesh& mesh_O,
                              const std::vector<PartSurface>& parts,
                              const std::vector<Pose>& X_OL,
                              const PoseContactOptions& options,
                              const Progress& progress);

}  // namespace handgraft::contact
