#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/session/models.h"

#include "tests/bench/retargeting/demonstration.h"
#include "tests/bench/retargeting/exact_penetration.h"
#include "tests/bench/retargeting/fingertips.h"
#include "tests/bench/retargeting/grasp_measure.h"

namespace handgraft::bench {

/// A hand with all that measuring needs of it.
struct MeasuredHand {
  std::string name;  ///< of its URDF
  hand::Hand hand;
  std::shared_ptr<const hand::HandModel> carrier;  ///< joints that place it, cut off; or null
  std::shared_ptr<const ExactHand> exact;
  std::vector<std::string> parts;  ///< the finger of each link
  Fingertips fingertips;
};

/// Errors: as readHand (chain_pair.h) and ExactHand.
MeasuredHand readMeasuredHand(const std::filesystem::path& urdf,
                              const std::filesystem::path& cache);

/// What one way of retargeting made of a demonstration.
struct Retargeted {
  hand::HandPose pose;
  GraspMeasure measure;
  double ms = 0.0;  ///< processor time of the solve
};

/// A patch of the demonstration, and what became of it on this hand.
struct RetargetedPatch {
  std::string name;
  std::string site;
  std::string dropped;  ///< why it is not asked of this hand
};

/// One grasp on one hand.
struct RetargetedGrasp {
  std::string hand;
  std::string object;
  std::string grasp;
  std::string refused;  ///< why there is no pose; the rest is empty then
  int digits_touching = 0;
  std::vector<RetargetedPatch> patches;
  int asked = 0;  ///< patches that were not dropped
  Retargeted ours;
  double ms_transfer = 0.0;   ///< to open the session, which tries ways, and to lay the patches
  double ms_pose = 0.0;       ///< the same and the session's solve
  double told_depth_m = 0.0;  ///< the product's own figures
  double told_self_m = 0.0;
  int joints_at_limits = 0;
  /// Mean distance of the joints from where the demonstrator had them; the same hand alone.
  std::optional<double> joints_mm;
  // What is used today; missing where the hand has too few fingers for it.
  std::optional<Retargeted> fingertips;
  std::optional<Retargeted> dex_pilot;
};

/// `handgraft grasp` without options, and the baselines beside it. `demonstrator` made the
/// demonstration.
RetargetedGrasp retarget(const MeasuredHand& hand,
                         const MeasuredHand& demonstrator,
                         const Demonstration& demonstration,
                         bool with_baselines);

}  // namespace handgraft::bench
