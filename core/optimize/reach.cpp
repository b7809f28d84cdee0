#include "core/optimize/reach.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "core/optimize/align_root.h"
#include "core/optimize/local_search.h"
#include "core/optimize/newton_search.h"

namespace handgraft::optimize {

namespace {

using Eigen::Vector3d;

constexpr int kEvaluations = 40;
constexpr double kFreePrior = 1e-6;  // keeps what the pair leaves open where it is

/// Centres of a patch's points on both sides, at a pose; the object's do not move.
struct Centres {
  Vector3d hand_W = Vector3d::Zero();
  Vector3d object_W = Vector3d::Zero();
};

Centres centresOf(const std::vector<PointPair>& pairs, int patch, const hand::LinkPoses& X_WL) {
  Centres centres;
  double count = 0.0;
  for (const PointPair& pair : pairs) {
    if (pair.patch != patch) continue;
    centres.hand_W += X_WL[static_cast<std::size_t>(pair.link)] * pair.p_L;
    centres.object_W += pair.p_W;
    count += 1.0;
  }
  centres.hand_W /= count;
  centres.object_W /= count;
  return centres;
}

/// Joints of start `index`: the start's, rest, half and fully on the way to the upper limits.
Eigen::VectorXd jointsOf(const PoseProblem& problem, int index) {
  const Eigen::VectorXd rest =
      problem.model->restPose().cwiseMax(problem.lower).cwiseMin(problem.upper);
  Eigen::VectorXd q = index == 0 ? problem.start.q : rest;
  for (Eigen::Index j = 0; j < q.size() && index >= 2; ++j) {
    const double room = problem.upper[j] - q[j];
    if (std::isfinite(room)) q[j] += (index == 2 ? 0.5 : 1.0) * room;
  }
  for (Eigen::Index j = 0; j < q.size() && !problem.locked.empty(); ++j) {
    if (problem.locked[static_cast<std::size_t>(6 + j)]) q[j] = problem.start.q[j];
  }
  return q;
}

/// The best that the hand can do about two patches.
SpanMisfit spanOf(const PoseProblem& problem, int a, int b, double allowance_m) {
  PoseProblem two = problem;
  two.avoidance.reset();
  two.pairs.clear();
  for (const PointPair& pair : problem.pairs) {
    if ((pair.patch == a || pair.patch == b) && pair.weight > 0.0) two.pairs.push_back(pair);
  }
  two.weights.distance = Weights().distance;  // what can be reached is no question of weights
  two.weights.normal = 0.0;
  two.weights.prior = kFreePrior;
  const PreparedProblem prepared(two);
  Objective objective(two, prepared.tree);
  NewtonSearch search(two, prepared.space, objective);
  SpanMisfit best;
  for (int index = 0; index < 4; ++index) {
    hand::HandPose pose = two.start;
    pose.q = jointsOf(two, index);
    pose.X_WH = alignRoot(two, *prepared.tree, pose.q, 0.0);
    search.begin(pose);
    int evaluations = kEvaluations;
    while (search.improve(evaluations) == NewtonSearch::Step::kBetter) {
    }
    const hand::LinkPoses X_WL = forwardKinematics(*two.model, search.pose());
    const Centres of_a = centresOf(two.pairs, a, X_WL);
    const Centres of_b = centresOf(two.pairs, b, X_WL);
    const SpanMisfit found{a, b, (of_a.object_W - of_b.object_W).norm(),
                           (of_a.hand_W - of_b.hand_W).norm()};
    if (index == 0 || std::abs(found.lack()) < std::abs(best.lack())) best = found;
    if (std::abs(best.lack()) <= allowance_m) break;
  }
  return best;
}

}  // namespace

std::vector<SpanMisfit> findSpanMisfits(const PoseProblem& problem, double allowance_m) {
  std::vector<SpanMisfit> misfits;
  if (boundsContradict(problem)) return misfits;
  std::map<int, int> patches;
  for (const PointPair& pair : problem.pairs) {
    if (pair.patch >= 0 && pair.weight > 0.0) ++patches[pair.patch];
  }
  for (auto a = patches.begin(); a != patches.end(); ++a) {
    for (auto b = std::next(a); b != patches.end(); ++b) {
      const SpanMisfit found = spanOf(problem, a->first, b->first, allowance_m);
      if (std::abs(found.lack()) > allowance_m) misfits.push_back(found);
    }
  }
  std::stable_sort(misfits.begin(), misfits.end(), [](const auto& x, const auto& y) {
    return std::abs(x.lack()) > std::abs(y.lack());
  });
  return misfits;
}

}  // namespace handgraft::optimize
