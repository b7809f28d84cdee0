#pragma once

namespace handgraft::transfer {

/// How well a patch keeps its shape on its way from the object onto the hand.
///
/// The patch is read as a net: its interpolation boundary, and shrunken copies of it towards
/// the root (or the axis). Lengths of the net's edges and angles of its triangles are compared
/// between the object's surface and the skin. Both are zero, and the ratio one, where the two
/// surfaces are isometric over the patch.
struct Fidelity {
  double distance_mean = 0.0;  ///< |length on the skin / length on the object - 1|
  double distance_max = 0.0;
  double angle_mean_rad = 0.0;
  double angle_max_rad = 0.0;
  double area_ratio = 1.0;  ///< area on the skin / area on the object, of what was not lost
  /// From the skin to the link's own surface, which the log map does not see.
  double projection_mean_m = 0.0;
  double projection_max_m = 0.0;
};

}  // namespace handgraft::transfer
