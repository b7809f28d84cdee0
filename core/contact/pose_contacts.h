#pragma once

#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/contact/contact_map.h"
#include "core/geometry/triangle_mesh.h"

namespace handgraft::contact {

/// A part of a hand where its pose puts it.
struct PosedSurface {
  std::string name;               ///< of the link; its finger is found by fingerOfSegment
  geometry::TriangleMesh mesh_O;  ///< faces counter-clockwise seen from outside
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

}  // namespace handgraft::contact
