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
  /// Distance at which contact ends. Fits of a hand's pose miss the surface by millimetres on
  /// either side; DexYCB's maps, made with this formula, use 10 mm.
  double reach_m = 0.010;
  /// The object's mesh is cut down to edges this long, so that patches have a shape.
  double longest_edge_m = 0.004;
};

/// The contact map of a posed hand by distance alone, for grasps that were recorded as poses:
/// at each vertex contact = max(0, 1 - d / reach) with the distance d to the nearest part, 1
/// inside of one; the label is that part's index, -1 where contact is 0.
///
/// A part need not be closed: inside is where its faces wind around the vertex by more than
/// half. Where parts overlap, inside counts before near, and the first of them wins.
///
/// Frames: all in O, metres. Errors: InvalidInput if an option is not above 0, the object or
/// all parts have no face, or no part is within reach: another frame, or a pose that touches
/// nothing (the message says how far the nearest part is). Cancelled on wish. Cost: a
/// nearest-place query per vertex and part within reach; O(part's faces) for each vertex in a
/// part's bounding box.
ContactMap contactsFromPose(const geometry::TriangleMesh& object_O,
                            const std::vector<PosedSurface>& parts_O,
                            const PoseContactOptions& options = {},
                            const Progress& progress = Progress());

}  // namespace handgraft::contact
