#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/hand/variant.h"
#include "core/optimize/avoidance.h"
#include "core/optimize/pose_problem.h"
#include "core/session/session.h"
#include "core/sweep/sweep.h"

/// What the rows of one grasp of a sweep have in common (sweep.h uses it).
namespace handgraft::sweep {

/// A grasp on the hand as it is: what all its rows begin with.
struct SweepBase {
  std::string error;               ///< why there is none; the rest is empty then
  std::vector<std::string> notes;  ///< as a session tells them
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

/// What a session answers that is opened on `hand` with the grasp: where patches lie, which
/// finger takes them and how the pose is searched is the session's alone.
/// Errors: InvalidInput as a session's; Cancelled on wish.
session::Solution solveAnew(const hand::Hand& hand,
                            const SweepGrasp& grasp,
                            const SweepOptions& options,
                            int threads,
                            const Progress& progress,
                            std::vector<std::string>* notes = nullptr);

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

/// The base's answer on a variant, each patch where the base has it: from the base's pose, and
/// from the starts of `options`.
/// Errors: InvalidInput if no patch has a point on the hand; Cancelled on wish.
session::Solution solveKept(const SweepBase& base,
                            const TransferredGrasp& laid,
                            const hand::HandVariant& variant,
                            const std::shared_ptr<const optimize::Avoidance>& solids,
                            const SweepOptions& options,
                            const Progress& progress);

/// Which of both a row tells: `kept` unless `anew` drops or misses fewer patches, or costs less
/// by more than searches differ by. So what is varied changes the rows, and none is worse than
/// a session.
const session::Solution& betterOf(const session::Solution& anew, const session::Solution& kept);

}  // namespace handgraft::sweep
