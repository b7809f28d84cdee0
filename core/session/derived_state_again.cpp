// What a search did not come to is tried anew: out of the object, and to what is missed.
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "core/optimize/diagnosis.h"
#include "core/session/derived_state_search.h"

namespace handgraft::session {
namespace {

using optimize::PoseProblem;
using optimize::SolveOptions;
using optimize::SolveReport;

// A patch that is missed weighs so many times as much for a moment; where that does not help,
// so many times as much again.
constexpr double kReachingWeight = 4.0;
constexpr int kReaches = 2;
constexpr int kWorseReaches = 2;  // slides in a row, while reaching for what is missed

// A hand that ends inside the object begins again so far from it, its fingers so far on the
// way to rest.
constexpr double kBacks[] = {0.0, 0.03, 0.06, 0.1};  // m
constexpr double kOpenings[] = {0.0, 0.5, 1.0};

Eigen::Vector3d centreOf(const std::vector<optimize::PointPair>& pairs) {
  Eigen::Vector3d centre_W = Eigen::Vector3d::Zero();
  for (const optimize::PointPair& pair : pairs)
    centre_W += pair.p_W / static_cast<double>(pairs.size());
  return centre_W;
}

/// A joint that moves nothing that touches may stand so far from where nothing holds it:
/// beyond, something has caught it.
constexpr double kCaught = 0.5;  // rad or m

/// Whether a joint that moves no patch stands far from `free`.
bool isCaught(const PoseProblem& posed, const Eigen::VectorXd& free, const Eigen::VectorXd& q) {
  const auto& nodes = posed.model->nodes();
  std::vector<char> moves_patch(static_cast<std::size_t>(posed.model->dofCount()), 0);
  for (const optimize::PointPair& pair : posed.pairs) {
    for (int link = pair.link; link > 0;) {
      const hand::HandModel::Node& node = nodes[static_cast<std::size_t>(link - 1)];
      if (node.dof >= 0) moves_patch[static_cast<std::size_t>(node.dof)] = 1;
      link = node.parent_link;
    }
  }
  for (Eigen::Index dof = 0; dof < q.size(); ++dof)
    if (moves_patch[static_cast<std::size_t>(dof)] == 0 &&
        std::abs(q[dof] - free[dof]) > kCaught)
      return true;
  return false;
}

Eigen::VectorXd withinLimits(const PoseProblem& posed, const Eigen::VectorXd& q) {
  return q.cwiseMax(posed.lower).cwiseMin(posed.upper);
}

}  // namespace

void DerivedState::approachAnew(const hand::HandPose& first,
                                SolveReport& report,
                                const SolverSettings& solving,
                                const SolveOptions& options,
                                const Progress& progress) {
  const SolveOptions step = stepOf(options);
  SolveOptions whole = options;
  whole.starts = 1;
  Worth worth = worthOf(report, solving);
  Search best(*this);
  const std::vector<SessionPatch> patches = patches_;
  const hand::HandPose from = report.pose;
  const PoseProblem posed = problem(solving);
  const Eigen::VectorXd open = withinLimits(posed, posed.model->restPose());
  const Eigen::Vector3d away_W = (from.X_WH.translation() - centreOf(posed.pairs)).normalized();
  std::vector<hand::HandPose> beginnings{first};
  for (const double back_m : kBacks) {
    for (const double opening : kOpenings) {
      hand::HandPose& beginning = beginnings.emplace_back(from);
      beginning.X_WH.translation() += back_m * away_W;
      beginning.q += opening * (open - beginning.q);
    }
  }
  for (const hand::HandPose& beginning : beginnings) {
    patches_ = patches;
    start_ = beginning;
    SolveReport other = optimize::solve(problem(solving), whole, progress);
    slideRoots(other, solving, step, progress, kWorseSlides);
    goOn(other, solving, options, progress);
    other.best_start = report.best_start;
    other.solver = report.solver;
    if (takeBetter(worthOf(other, solving), other, worth, report)) best.keep();
  }
}

void DerivedState::beginOpen(SolveReport& report,
                             const SolverSettings& solving,
                             const SolveOptions& options,
                             const Progress& progress) {
  SolveOptions whole = options;
  whole.starts = 1;
  Worth worth = worthOf(report, solving);
  const PoseProblem posed = problem(solving);
  const Eigen::VectorXd rest = withinLimits(posed, posed.model->restPose());
  // A pose that is known is the prior, too, and the same joints may be caught there.
  const Eigen::VectorXd free =
      holdsPosture(solving) ? withinLimits(posed, posed.prior.q) : rest;
  if (worth.first == 0 && !isCaught(posed, free, report.pose.q)) return;
  Search best(*this);
  start_ = {report.pose.X_WH, rest};
  SolveReport other = optimize::solve(problem(solving), whole, progress);
  slideRoots(other, solving, stepOf(options), progress, kWorseReaches);
  goOn(other, solving, options, progress);
  other.best_start = report.best_start;
  other.solver = report.solver;
  if (takeBetter(worthOf(other, solving), other, worth, report)) best.keep();
}

void DerivedState::weigh(const std::vector<int>& patches, double factor) {
  for (const int k : patches) {
    SessionPatch& item = patches_[static_cast<std::size_t>(k)];
    item.patch.weight *= factor;
    for (transfer::Correspondence& pair : item.transferred.correspondences)
      pair.weight = item.patch.weight;
  }
}

void DerivedState::reweightMissedPatches(SolveReport& report,
                                         const SolverSettings& solving,
                                         const SolveOptions& options,
                                         const Progress& progress) {
  const SolveOptions step = stepOf(options);
  Worth worth = worthOf(report, solving);
  Search best(*this);
  double factor = kReachingWeight;
  for (int i = 0; i < kReaches && worth.first > 0; ++i) {
    patches_ = best.patches;
    start_ = report.pose;
    const std::vector<int> missed = optimize::missedPatches(problem(solving), report);
    weigh(missed, factor);
    SolveReport other = optimize::solve(problem(solving), step, progress);
    slideRoots(other, solving, step, progress, kWorseReaches);
    weigh(missed, 1.0 / factor);
    start_ = other.pose;
    other = optimize::solve(problem(solving), step, progress);
    slideRoots(other, solving, step, progress, kWorseReaches);
    // What is reached on the way counts if it is at the end.
    if (worthOf(other, solving) < worth) goOn(other, solving, options, progress);
    other.best_start = report.best_start;
    other.solver = report.solver;
    if (takeBetter(worthOf(other, solving), other, worth, report)) {
      best.keep();
    } else {
      factor *= kReachingWeight;
    }
  }
}

}  // namespace handgraft::session
