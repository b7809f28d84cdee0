#pragma once

#include <vector>

#include "core/optimize/pose_problem.h"

namespace handgraft::optimize {

/// Two patches that no pose brings onto their places at once.
struct SpanMisfit {
  int patch_a = -1;
  int patch_b = -1;
  double object_m = 0.0;  ///< between their centres on the object
  double hand_m = 0.0;    ///< the nearest that the hand's places come to it, within the limits

  /// By so much (m) the hand is too small, if positive; too large, if negative.
  [[nodiscard]] double lack() const { return object_m - hand_m; }
};

/// For each pair of patches: can the hand hold their two places as far apart as they lie on the
/// object, within its limits? Found before any search for the whole hand, and whatever the
/// pose: both patches alone, their distances alone, from four starts.
///
/// A necessary condition. What the hand may miss by `allowance_m` is no misfit; the default is
/// twice what counts as reached (diagnosis.h), since each of the two may be off by that.
/// Largest first. Locks hold, the root is free unless it is locked.
/// Errors: BrokenContract if the problem's sizes disagree. Cost: 0.1 ms a pair that fits, 0.4
/// ms one that does not.
std::vector<SpanMisfit> findSpanMisfits(const PoseProblem& problem, double allowance_m = 0.012);

}  // namespace handgraft::optimize
