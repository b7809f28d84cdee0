#pragma once

#include "core/contact/contact_map.h"
#include "core/contact/contact_set.h"

namespace handgraft::contact {

struct SegmentationOptions {
  double threshold = 0.4;         ///< contact above this counts
  double minimum_area_m2 = 2e-5;  ///< smaller components are dropped, with a note
  int interpolation_count = kDefaultInterpolationCount;
};

/// Splits a contact map into patches: threshold, group the labels by finger, connected
/// components of the faces that are in contact at all three corners, one patch per finger (the
/// component with the most contact, integrated over its area; the rest is dropped and noted),
/// root at the component's geodesic centre, ordered outer boundary, IB. Directions stay open.
///
/// Without labels, or where no segment's name says a finger, every component becomes a patch,
/// named c1, c2, ... by falling area. A finger whose contact covers the minimum area, but no
/// face whole, as on coarse meshes, gets all faces that it touches, with a note.
///
/// Errors: InvalidInput if the map or an option is wrong (named), or if nothing is left: then
/// the
///   message says what was dropped. Cost: O(V log V).
ContactSet segment(const ContactMap& map, const SegmentationOptions& options);

}  // namespace handgraft::contact
