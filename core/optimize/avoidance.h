#pragma once

#include <memory>

#include "core/geometry/solid.h"
#include "core/hand/hand_solid.h"

namespace handgraft::optimize {

/// What a pose pays for lying inside the object, or in itself.
///
/// The charge is `weight` times the sum over samples of
///   (area / kPointArea) (depth + margin)^2,
/// as if a contact point every 10 mm^2 wanted to be out: samples of the hand in the object,
/// samples of the object's thin walls and edges in the links, samples of one link in another.
/// All are zero, and flat, for a hand that touches nothing.
/// Differs from the paper, whose objective knows no collision.
struct Avoidance {
  static constexpr double kPointArea = 1e-5;  // m^2

  std::shared_ptr<const hand::HandSolid> hand;
  std::shared_ptr<const geometry::Solid> object_O;
  Pose X_WO = Pose::Identity();
  /// 1/m^2: five hundred times that of a contact point's distance, so that a patch that wants
  /// to be millimetres inside stays out but for tenths.
  double weight = 5e6;
  /// m; what lies between two samples may be so much deeper than they are.
  double margin_m = 2e-4;
  double self_margin_m = 7e-4;  ///< of one link in another: both are sampled, both are rounded
};

/// How closely a search looks.
struct AvoidanceLevel {
  bool fine = true;    ///< by all samples; else by a tenth of the hand's
  double share = 1.0;  ///< of the weight

  bool operator==(const AvoidanceLevel&) const = default;
};

}  // namespace handgraft::optimize
