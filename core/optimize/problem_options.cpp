#include "core/optimize/problem_options.h"

#include <cmath>

#include "core/base/error.h"

namespace handgraft::optimize {

namespace {

void requireFactor(double factor, const std::string& name) {
  // Written so that a NaN fails, too.
  if (!(factor >= 0.0) || std::isinf(factor)) {
    rejectInput("{}: {} must be finite and at least 0", name, factor);
  }
}

Eigen::VectorXd& priorWeights(PoseProblem& problem) {
  if (problem.prior_weights.size() == 0) {
    problem.prior_weights = Eigen::VectorXd::Ones(problem.dofCount());
  }
  return problem.prior_weights;
}

}  // namespace

void scalePrior(const PriorShares& shares, PoseProblem& problem) {
  requireFactor(shares.root_rotation, "prior share of the root's rotation");
  requireFactor(shares.root_translation, "prior share of the root's translation");
  requireFactor(shares.joints, "prior share of the joints");
  Eigen::VectorXd& weights = priorWeights(problem);
  weights.head<3>() *= shares.root_rotation;
  weights.segment<3>(3) *= shares.root_translation;
  weights.tail(weights.size() - 6) *= shares.joints;
}

void scalePatch(int patch, double factor, PoseProblem& problem) {
  requireFactor(factor, fmt::format("weight of patch {}", patch));
  bool found = false;
  for (PointPair& pair : problem.pairs) {
    if (pair.patch != patch) continue;
    pair.weight *= factor;
    found = true;
  }
  if (!found) rejectInput("patch {}: the problem has no pair of it", patch);
}

void holdSoftly(int joint, double value, double weight, PoseProblem& problem) {
  HANDGRAFT_REQUIRE(joint >= 0 && joint < problem.model->dofCount());
  const std::string name = "joint " + quoted(dofName(problem, 6 + joint));
  requireFactor(weight, name + ": weight");
  if (!(value >= problem.lower[joint] && value <= problem.upper[joint])) {
    rejectInput("{}: {:.9g} lies outside its bounds [{:.9g}, {:.9g}]", name, value,
                problem.lower[joint], problem.upper[joint]);
  }
  priorWeights(problem)[6 + joint] *= weight;
  problem.prior.q[joint] = value;
}

void lock(int dof, PoseProblem& problem) {
  HANDGRAFT_REQUIRE(dof >= 0 && dof < problem.dofCount());
  problem.locked.resize(static_cast<std::size_t>(problem.dofCount()), false);
  problem.locked[static_cast<std::size_t>(dof)] = true;
}

}  // namespace handgraft::optimize
