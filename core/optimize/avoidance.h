#pragma once

#include <memory>

#include "core/geometry/distance_grid.h"
#include "core/hand/hand_solid.h"

namespace handgraft::optimize {

/// What a pose pays for lying inside the object, or in itself.
///
/// The charge is `weight` times the sum over the hand's coarse samples of
///   (area / kPointArea) depth^2,
/// as if a contact point every 10 mm^2 wanted to be out; of one link in another likewise. Both
/// are zero, and flat, for a hand that touches nothing.
/// Differs from the paper, whose objective knows no collision.
struct Avoidance {
  static constexpr double kPointArea = 1e-5;  // m^2

  std::shared_ptr<const hand::HandSolid> hand;
  std::shared_ptr<const geometry::DistanceGrid> object_O;
  Pose X_WO = Pose::Identity();
  double weight = 1e5;  ///< 1/m^2: ten times that of a contact point's distance
};

}  // namespace handgraft::optimize
