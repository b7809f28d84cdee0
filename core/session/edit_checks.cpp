#include "core/session/edit_checks.h"

#include "core/base/error.h"

namespace handgraft::session {
namespace {

constexpr double kRotationTolerance = 1e-6;

}  // namespace

void requireRigid(const Pose& X, const char* what) {
  const Eigen::Matrix3d R = X.linear();
  if (!X.matrix().allFinite()) rejectInput("{} is not finite", what);
  if (!(R.transpose() * R).isIdentity(kRotationTolerance) || !(R.determinant() > 0.0)) {
    rejectInput("{} is no rigid motion: its rotation's determinant is {:.6g}, it must be 1",
                what, R.determinant());
  }
  const double farthest = X.translation().cwiseAbs().maxCoeff();
  if (farthest > kLargestPosition) {
    rejectInput("{} is {} m away; permitted are {}", what, farthest, kLargestPosition);
  }
}

void requireWithin(
    double value, double least, double most, const std::string& what, const std::string& unit) {
  if (!(value >= least && value <= most)) {
    const std::string behind = unit.empty() ? "" : " " + unit;
    rejectInput("{} is {}{}; permitted are {} to {}{}", what, value, behind, least, most,
                behind);
  }
}

void validateWeights(const optimize::Weights& weights) {
  requireWithin(weights.distance, 0.0, kLargestLambda, "weight of the distance");
  requireWithin(weights.normal, 0.0, kLargestLambda, "weight of the normals");
  requireWithin(weights.prior, 0.0, kLargestLambda, "weight of the prior");
  if (weights.distance == 0.0 && weights.normal == 0.0 && weights.prior == 0.0) {
    rejectInput("weights of distance, normals and prior are all 0; one must be above");
  }
}

void validateShares(const optimize::PriorShares& shares) {
  requireWithin(shares.root_rotation, 0.0, kLargestLambda,
                "prior share of the root's rotation");
  requireWithin(shares.root_translation, 0.0, kLargestLambda,
                "prior share of the root's translation");
  requireWithin(shares.joints, 0.0, kLargestLambda, "prior share of the joints");
  requireWithin(shares.posture, 0.0, kLargestLambda, "prior share of the posture");
}

}  // namespace handgraft::session
