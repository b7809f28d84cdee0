#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

namespace handgraft::transfer {

/// How well a patch keeps its shape on its way from the object onto the hand.
///
/// The patch is read as a net: its interpolation boundary, and shrunken copies of it towards
/// the root. Lengths of the net's edges and angles of its triangles are compared
/// between the object's surface and the skin. Both are zero, and the ratio one, where the two
/// surfaces are isometric over the patch, and where too little is left to compare.
///
/// Means are weighted by the length of the edge and the area of the triangle on the object.
/// Edges and triangles that the object has (nearly) shrunk to nothing say nothing and are left
/// out: edges below a thousandth of the net's longest, triangles thinner than 1:20.
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

/// A knot of the net, where it lies on both surfaces.
struct NetKnot {
  bool valid = false;  ///< it has a place on both
  Eigen::Vector3d p_O = Eigen::Vector3d::Zero();
  Eigen::Vector3d p_S = Eigen::Vector3d::Zero();
};

/// Compares a net of closed rows, the innermost first, each with as many knots as the next:
/// knot (row, i) hangs together with (row, i + 1) and (row + 1, i). Leaves the projection at
/// zero. Units: metres. Cost: O(knots).
Fidelity fidelityOf(const std::vector<std::vector<NetKnot>>& rows);

/// What to say of a patch whose shape did not come through: "lengths 35 %, angles 55 deg, area
/// x 0.38". Empty below 15 % and 15 degrees in the mean: on intact scans patches lie below 5 %
/// and 5 degrees, on ones with holes under the contact above.
std::string distortionOf(const Fidelity& fidelity);

}  // namespace handgraft::transfer
