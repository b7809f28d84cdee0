#pragma once

#include "core/optimize/pose_problem.h"

namespace handgraft::optimize {

// What a user may ask of a problem beyond Eq. 2-5. All of it ends in the weights and locks that
// a PoseProblem has anyway, so that an exported problem means the same. The defaults, all 1,
// are the paper's.

/// How much the prior holds each kind of degree of freedom.
struct PriorShares {
  double root_rotation = 1.0;
  double root_translation = 1.0;
  double joints = 1.0;
  /// Before any pose is known the prior is the hand's posture, and weighs so many times as
  /// much. Measured (core/session); 0: no posture, as in the paper.
  double posture = 50.0;
};

/// Multiplies the prior's weights by kind. Errors: InvalidInput below 0.
void scalePrior(const PriorShares& shares, PoseProblem& problem);

/// Multiplies the weights of a patch's pairs. Errors: InvalidInput below 0, or if the problem
/// has no pair of that patch.
void scalePatch(int patch, double factor, PoseProblem& problem);

/// Holds a joint softly at `value`: its prior moves there and weighs `weight` times as much.
/// Errors: InvalidInput if the value lies outside the bounds, or the weight below 0.
void holdSoftly(int joint, double value, double weight, PoseProblem& problem);

/// Holds a degree of freedom where the start has it.
void lock(int dof, PoseProblem& problem);

}  // namespace handgraft::optimize
