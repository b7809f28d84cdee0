#pragma once

#include <optional>
#include <vector>

#include "core/contact/contact_map.h"
#include "core/contact/contact_set.h"
#include "core/contact/finger_assignment.h"

namespace handgraft::contact {

/// How the threshold is found.
enum class ThresholdRule {
  kGiven,  ///< SegmentationOptions::threshold
  /// Otsu's, over the vertices whose value is above 0, weighted by their areas: for maps whose
  /// values mean nothing absolute, as temperatures.
  kOtsu,
};

struct SegmentationOptions {
  double threshold = 0.4;  ///< contact above this counts
  ThresholdRule rule = ThresholdRule::kGiven;
  /// With it, contact above this share of the threshold counts too where it hangs together with
  /// contact above the threshold (of the same finger); in (0, 1].
  double low_share = 1.0;
  int smoothing_steps = 0;  ///< of threshold.h, before anything else
  /// A patch ends where contact falls below this share of what its region reaches (outline.h);
  /// in [0, 1). 0: where it falls below the threshold.
  double outline_share = 0.75;
  double minimum_area_m2 = 2e-5;  ///< smaller components are dropped, with a note
  int interpolation_count = kDefaultInterpolationCount;
  /// Of the hand that touched. Finds the finger of each patch where the map's labels do not
  /// tell, splits regions that several fingers touch, and gives patches their directions.
  std::optional<HandJoints> joints_O;
  /// Of other hands that touched, too: what is nearer to them is left out (own_contact.h).
  std::vector<HandJoints> other_joints_O{};
};

/// Splits a contact map into patches: smoothing, threshold, parts of the hand by joints where
/// labels do not name any, connected components of the faces that are in contact at all three
/// corners with one part (a segment of a digit, a digit whose segments nobody tells, the palm),
/// cut to the outline of what touches, root at the component's geodesic centre, ordered outer
/// boundary, IB. Directions lead towards the wrist and patches have places where joints are
/// given, and stay open otherwise.
///
/// A segment and the palm give a patch for each component of at least the minimum area, the one
/// with most contact (integrated over its area) first: `index_middle`, `index_middle_2`; a
/// digit without segments gives one. What a segment has of a digit's region beside others is
/// theirs if it is less than 15 %. What is dropped is noted.
///
/// Without labels, or where no segment's name says a finger, every component becomes a patch,
/// named c1, c2, ... by falling area; one whose outline falls into several parts (two fingers
/// whose contact runs together) gives one for each, those beside the first behind all others.
/// Of a finger the part with most contact counts, and a note tells the rest. A finger whose
/// contact covers the minimum area, but no face whole, as on coarse meshes, gets all faces that
/// it touches, with a note.
///
/// Errors: InvalidInput if the map or an option is wrong (named), or if nothing is left: then
/// the
///   message says what was dropped. Cost: O(V log V).
ContactSet segment(const ContactMap& map, const SegmentationOptions& options);

/// The threshold that the options mean for this map: theirs, or Otsu's of its values as they
/// stand. Errors: InvalidInput if Otsu's rule finds fewer than two values above 0.
double thresholdOf(const ContactMap& map, const SegmentationOptions& options);

}  // namespace handgraft::contact
