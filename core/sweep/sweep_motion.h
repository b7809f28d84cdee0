#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/hand/variant.h"
#include "core/manipulation/transfer_patches.h"
#include "core/retargeting/motion_solving.h"
#include "core/sweep/sweep.h"

/// What the rows of one motion of a sweep have in common (sweep.h uses it).
namespace handgraft::sweep {

/// A motion on the hand as it is: what all its rows begin with.
struct SweepMotionBase {
  std::string error;  ///< why there is none; the rest is empty then
  std::shared_ptr<const retargeting::SolvedMotion> solved;
  /// The motion, each key with the place on the hand that it was laid at.
  manipulation::Motion motion;

  [[nodiscard]] std::vector<std::string> notes() const {
    return solved ? solved->notes : std::vector<std::string>();
  }
};

/// Solves the motion as a session would. An InvalidInput is told in `error`. Cancelled on wish.
SweepMotionBase solveMotionBase(const hand::Hand& hand,
                                const SweepGrasp& grasp,
                                const SweepOptions& options,
                                int threads,
                                const Progress& progress);

/// A motion's patches on one shape of the hand.
struct LaidSweepMotion {
  std::string error;
  manipulation::TransferredMotion laid;
};

/// The base's places on a skin that was bent; without one (`bent` null), as the base has them.
/// Recorded points go with the skin next to them.
LaidSweepMotion layMotion(const SweepMotionBase& base,
                          const hand::Hand& original,
                          const geometry::TriangleMesh& object_O,
                          const transfer::Surfaces* bent,
                          const transfer::TransferOptions& options,
                          const Progress& progress);

/// Has a variant follow the motion; penetration costs what it costs the base. Of `row` what the
/// answer says.
/// Errors: InvalidInput; Cancelled.
void solveMotionRow(const SweepMotionBase& base,
                    const LaidSweepMotion& laid,
                    const hand::HandVariant& variant,
                    const std::shared_ptr<const optimize::Avoidance>& solids,
                    const Progress& progress,
                    SweepRow& row);

}  // namespace handgraft::sweep
