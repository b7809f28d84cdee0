#include "core/optimize/pose_problem.h"

#include <array>
#include <cmath>

#include "core/base/error.h"

namespace handgraft::optimize {

namespace {

constexpr double kBoundTolerance = 1e-9;     // rad or m; what rounding in files may cost
constexpr double kUnitTolerance = 1e-3;      // normals written with four decimals
constexpr double kRotationTolerance = 1e-6;  // entries of R^T R - I

void requireWeight(double value, const std::string& name) {
  if (!std::isfinite(value) || value < 0.0) {
    rejectInput("{}: {} must be finite and at least 0", name, value);
  }
}

void requireSize(Eigen::Index size, Eigen::Index expected, const char* name) {
  if (size != expected) {
    rejectInput("{}: has {} entries; it must have {}", name, size, expected);
  }
}

void validatePair(const PoseProblem& problem, std::size_t index) {
  const PointPair& pair = problem.pairs[index];
  const int links = problem.model->linkCount();
  if (pair.link < 0 || pair.link >= links) {
    rejectInput("pair {}: link {} does not exist; links are 0 to {}", index, pair.link,
                links - 1);
  }
  if (pair.patch < -1) rejectInput("pair {}: patch {} must be at least -1", index, pair.patch);
  if (!(std::isfinite(pair.weight) && pair.weight >= 0.0))
    requireWeight(pair.weight, fmt::format("pair {}: weight", index));
  if (!pair.p_L.allFinite() || !pair.p_W.allFinite()) {
    rejectInput("pair {}: its points must be finite", index);
  }
  if (!pair.has_normals) return;
  const auto require_unit = [index](const Eigen::Vector3d& n, const char* side) {
    const double norm = n.norm();
    // Written so that a NaN fails, too.
    if (!(std::abs(norm - 1.0) <= kUnitTolerance)) {
      rejectInput("pair {}: the {} normal has length {:.6g}; it must be 1 within {}", index,
                  side, norm, kUnitTolerance);
    }
  };
  require_unit(pair.n_L, "hand");
  require_unit(pair.n_W, "object");
}

void validatePose(const hand::HandPose& pose, Eigen::Index joints, const char* name) {
  requireSize(pose.q.size(), joints, name);
  if (!pose.q.allFinite() || !pose.X_WH.matrix().allFinite()) {
    rejectInput("{}: every value must be finite", name);
  }
  const Eigen::Matrix3d R = pose.X_WH.linear();
  const Eigen::Matrix3d defect = R.transpose() * R - Eigen::Matrix3d::Identity();
  if (defect.cwiseAbs().maxCoeff() > kRotationTolerance || R.determinant() < 0.0) {
    rejectInput(
        "{}: the root's rotation is not a rotation (R^T R differs from 1 by {:.3g}, "
        "determinant {:.3g})",
        name, defect.cwiseAbs().maxCoeff(), R.determinant());
  }
}

/// One bound pair and the start between them, unless the bounds contradict each other.
void validateBound(const std::string& name, double lower, double upper, double start) {
  if (std::isnan(lower) || std::isnan(upper)) {
    rejectInput("{}: bounds [{}, {}] must be numbers", name, lower, upper);
  }
  if (lower > upper) return;
  if (start < lower - kBoundTolerance || start > upper + kBoundTolerance) {
    rejectInput("{}: the start {:.9g} lies outside its bounds [{:.9g}, {:.9g}]", name, start,
                lower, upper);
  }
}

void validateAvoidance(const PoseProblem& problem) {
  const Avoidance& avoidance = *problem.avoidance;
  HANDGRAFT_REQUIRE(avoidance.hand != nullptr && avoidance.object_O != nullptr);
  requireWeight(avoidance.weight, "weight of penetration");
  if (!avoidance.X_WO.matrix().allFinite()) {
    rejectInput("pose of the object to stay out of: every value must be finite");
  }
  for (const hand::LinkSolid& solid : avoidance.hand->links())
    HANDGRAFT_REQUIRE(solid.link < problem.model->linkCount());
}

}  // namespace

std::string dofName(const PoseProblem& problem, int dof) {
  static constexpr std::array<const char*, 6> kRootNames = {"root_rx", "root_ry", "root_rz",
                                                            "root_tx", "root_ty", "root_tz"};
  HANDGRAFT_REQUIRE(dof >= 0 && dof < problem.dofCount());
  if (dof < 6) return kRootNames[static_cast<std::size_t>(dof)];
  return problem.model->dofJoint(dof - 6).name;
}

PoseProblem makeProblem(std::shared_ptr<const hand::HandModel> model) {
  HANDGRAFT_REQUIRE(model != nullptr);
  PoseProblem problem;
  problem.start.q = model->restPose();
  problem.prior = problem.start;
  problem.lower = model->lower();
  problem.upper = model->upper();
  problem.model = std::move(model);
  return problem;
}

bool boundsContradict(const PoseProblem& problem) {
  return (problem.lower.array() > problem.upper.array()).any() ||
         (problem.root_lower.array() > problem.root_upper.array()).any();
}

void validate(const PoseProblem& problem) {
  if (problem.model == nullptr) rejectInput("problem: has no hand");
  const int joints = problem.model->dofCount();
  requireWeight(problem.weights.distance, "weight of the distance");
  requireWeight(problem.weights.normal, "weight of the normals");
  requireWeight(problem.weights.prior, "weight of the prior");

  validatePose(problem.start, joints, "start");
  validatePose(problem.prior, joints, "prior");
  requireSize(problem.lower.size(), joints, "lower bounds");
  requireSize(problem.upper.size(), joints, "upper bounds");
  for (int i = 0; i < 3; ++i) {
    validateBound(dofName(problem, 3 + i), problem.root_lower[i], problem.root_upper[i],
                  problem.start.X_WH.translation()[i]);
  }
  for (int j = 0; j < joints; ++j) {
    validateBound("joint " + quoted(dofName(problem, 6 + j)), problem.lower[j],
                  problem.upper[j], problem.start.q[j]);
  }

  if (problem.prior_weights.size() != 0) {
    requireSize(problem.prior_weights.size(), problem.dofCount(), "prior weights");
    for (int i = 0; i < problem.dofCount(); ++i) {
      requireWeight(problem.prior_weights[i], "prior weight of " + quoted(dofName(problem, i)));
    }
  }
  if (!problem.locked.empty()) {
    requireSize(static_cast<Eigen::Index>(problem.locked.size()), problem.dofCount(), "locked");
  }
  for (std::size_t i = 0; i < problem.pairs.size(); ++i)
    validatePair(problem, i);
  if (problem.avoidance != nullptr) validateAvoidance(problem);
}

}  // namespace handgraft::optimize
