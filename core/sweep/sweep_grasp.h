#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/optimize/pose_problem.h"
#include "core/session/session.h"
#include "core/sweep/sweep.h"

/// What the rows of one grasp of a sweep have in common (sweep.h uses it).
namespace handgraft::sweep {

/// A grasp on the hand as it is: what all its rows begin with.
struct SweepBase {
  std::string error;  ///< why there is none; the rest is empty then
  std::vector<session::SessionPatch> patches;
  std::shared_ptr<const geometry::LogMapper> object_O;
  hand::HandPose solved;
  hand::HandPose prior;
  Eigen::VectorXd prior_weights;  ///< as a problem has them
};

/// Opens a session and solves it. An InvalidInput is told in `error`. Cancelled on wish.
SweepBase solveBase(const hand::Hand& hand,
                    const SweepGrasp& grasp,
                    const SweepOptions& options,
                    int threads,
                    const Progress& progress);

/// Where the points of a grasp's patches lie on one shape of the hand, in pairs as a problem
/// has them, the object's frame being the world.
struct TransferredGrasp {
  std::string error;
  std::vector<optimize::PointPair> pairs;
};

/// The base's places (faces, weights) on a skin that was bent; without one (`bent` null), as
/// the base has them. `bent` lacks the object, whose charts are the base's.
TransferredGrasp layGrasp(const SweepBase& base,
                          const hand::Skin& original,
                          const transfer::Surfaces* bent,
                          const transfer::TransferOptions& options,
                          const Progress& progress);

}  // namespace handgraft::sweep
