#pragma once

#include "core/contact/contact_map.h"
#include "core/contact/contact_set.h"
#include "core/geometry/triangle_mesh.h"

namespace handgraft::contact {

struct SegmentationOptions {
  double threshold = 0.4;       ///< contact above this counts
  double minimum_area_m2 = 2e-5;  ///< smaller components are dropped, with a note
  int interpolation_count = kDefaultInterpolationCount;
};

/// Splits a contact map into patches: threshold, group the labels by finger, connected
/// components, one patch per finger (the component with the largest summed contact; the rest is
/// dropped and noted), root at the component's geodesic centre, ordered outer boundary, IB.
/// Without labels every component becomes a patch, named c1, c2, ... by falling area.
///
/// Errors: InvalidInput if nothing is left. Cost: O(V log V).
ContactSet segment(const ContactMap& map, const SegmentationOptions& options);

/// The same map on another mesh of the same object, by nearest point on the map's surface;
/// vertices farther than `reach_m` get no contact. Frames: both meshes in O.
/// Errors: InvalidInput if more than half of the contact finds no vertex: another object or frame.
ContactMap carry(const ContactMap& map,
                 const geometry::TriangleMesh& object_O,
                 double reach_m = 0.005);

}  // namespace handgraft::contact
