#include "core/manipulation/causal_solver.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/error.h"
#include "core/optimize/avoiding_solve.h"
#include "core/optimize/newton_search.h"
#include "core/optimize/objective.h"
#include "core/optimize/solver.h"

namespace handgraft::manipulation {

namespace {

// Share of a velocity that goes on to the next frame: with it the answer to a step of the
// contacts does not swing (README).
constexpr double kMomentum = 0.7;

constexpr int kMostEvaluations = 20;

// Depth beside what a grasp pays for it: contacts that run ahead of the hand would pull it into
// the object meanwhile (DECISIONS).
constexpr double kDepthShare = 4.0;

// Share of the objective; a tenth of a millimetre of one point among fifty.
constexpr double kPromise = 1e-5;

double joined(double a, double weight_a, double b, double weight_b) {
  const double sum = weight_a + weight_b;
  return sum > 0.0 ? (weight_a * a + weight_b * b) / sum : a;
}

}  // namespace

CausalSolver::CausalSolver(const MotionProblem& problem, const MotionOptions& options)
    : problem_(problem), options_(options) {}

void CausalSolver::begin(const hand::HandPose& X_OH) {
  last_ = Past{0.0, X_OH};
  before_.reset();
  waits_ = true;
  damping_ = 0.0;
}

hand::HandPose CausalSolver::ahead(double step_s) const {
  hand::HandPose pose = last_->pose;
  if (!before_) return pose;
  const double share = kMomentum * step_s / (last_->time_s - before_->time_s);
  const Pose& X = last_->pose.X_WH;
  const Pose& pose_before = before_->pose.X_WH;
  pose.X_WH.translation() += share * (X.translation() - pose_before.translation());
  const Eigen::Vector3d turn =
      vectorFromRotation(X.linear() * pose_before.linear().transpose());
  pose.X_WH.linear() = rotationFromVector(share * turn) * X.linear();
  pose.q += share * (last_->pose.q - before_->pose.q);
  return pose;
}

void CausalSolver::narrow(double step_s, optimize::PoseProblem& single) const {
  const Eigen::VectorXd& q = last_->pose.q;
  const Eigen::VectorXd lower = single.lower;
  const Eigen::VectorXd upper = single.upper;
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    const double velocity =
        before_ ? (q[i] - before_->pose.q[i]) / (last_->time_s - before_->time_s) : 0.0;
    const double fastest = problem_.velocity_limit[i];
    const double brake = problem_.acceleration_limit[i];
    // What can be stopped before the limit, a step at a time: v^2 / 2a + v step <= way.
    const auto stoppable = [&](double way) {
      if (!std::isfinite(brake) || !std::isfinite(way)) return fastest;
      const double lost = brake * step_s;
      return std::min(fastest,
                      std::sqrt(lost * lost + 2.0 * brake * std::max(way, 0.0)) - lost);
    };
    double low = std::max(-stoppable(q[i] - lower[i]), velocity - brake * step_s);
    double high = std::min(stoppable(upper[i] - q[i]), velocity + brake * step_s);
    // Too fast already: the brake gives way, then the velocity.
    if (low > high) low = high = std::clamp(0.5 * (low + high), -fastest, fastest);
    single.lower[i] = std::clamp(q[i] + low * step_s, lower[i], upper[i]);
    single.upper[i] = std::clamp(q[i] + high * step_s, single.lower[i], upper[i]);
  }
}

CausalSolver::Step CausalSolver::follow(double time_s, optimize::PoseProblem single) {
  HANDGRAFT_REQUIRE(last_.has_value());
  if (waits_) last_->time_s = time_s - kReferenceStep;
  waits_ = false;
  const double step_s = time_s - last_->time_s;
  if (!std::isfinite(time_s) || !(step_s > 0.0)) {
    rejectInput("a frame at {} s does not lie behind the one before it, {} s", time_s,
                last_->time_s);
  }

  // === Two quadratics a coordinate, the prior's and that of what is smooth, are one
  const hand::HandPose target = ahead(step_s);
  const double rate = kReferenceStep / step_s;
  const double smoothness = options_.smoothness * rate * rate * rate * rate;
  const int dofs = single.dofCount();
  const double prior_weight = single.weights.prior;
  Eigen::VectorXd weights(dofs);
  weights.head<3>().setConstant(smoothness * kTurnScale);
  weights.segment<3>(3).setConstant(smoothness * kShiftScale);
  for (int i = 0; i < dofs - 6; ++i) {
    const bool slides = problem_.model->dofJoint(i).type == hand::JointType::kPrismatic;
    const double own = prior_weight * single.prior_weights[6 + i];
    const double smooth = smoothness * (slides ? kSliderScale : 1.0);
    weights[6 + i] = own + smooth;
    single.prior.q[i] = joined(single.prior.q[i], own, target.q[i], smooth);
  }
  single.prior.X_WH = target.X_WH;
  single.prior_weights = weights;
  single.weights.prior = 1.0;
  narrow(step_s, single);
  single.start = target;
  single.start.q = target.q.cwiseMax(single.lower).cwiseMin(single.upper);

  // === Downhill from there
  const auto tree = std::make_shared<const optimize::MomentTree>(makeMomentTree(single));
  const optimize::SearchSpace space = makeSearchSpace(single, *tree);
  optimize::Objective objective(single, tree);
  objective.level({true, kDepthShare});
  objective.swapNear(near_);  // as the last frame left them
  optimize::NewtonSearch search(single, space, objective);
  search.settings.promise = kPromise;
  search.settings.first_damping = 1e-3;
  search.begin(single.start, damping_);
  int evaluations = kMostEvaluations;
  while (evaluations > 0 &&
         search.improve(evaluations) == optimize::NewtonSearch::Step::kBetter) {
  }
  objective.swapNear(near_);
  damping_ = std::clamp(search.damping(), 1e-6, 1e-1);

  Step step;
  step.pose = search.pose();
  step.objective = search.terms().objective - search.terms().prior;
  step.evaluations = kMostEvaluations - evaluations + 1;
  before_ = std::move(last_);
  last_ = Past{time_s, step.pose};
  return step;
}

int fullestBegin(const MotionProblem& problem, const FrameProblems& frames) {
  std::vector<double> counts(problem.time_s.size(), 0.0);
  for (std::size_t k = 0; k < counts.size(); ++k) {
    for (const FrameProblems::Present& present : frames.presentAt(static_cast<int>(k))) {
      const PairTrack& track = problem.tracks[static_cast<std::size_t>(present.track)];
      counts[k] += present.presence * static_cast<double>(track.spans.front().pairs.size());
    }
  }
  const double most = *std::max_element(counts.begin(), counts.end());
  const auto first = std::find_if(counts.begin(), counts.end(), [most](double count) {
    return count >= 0.5 * most;
  });
  return static_cast<int>(first - counts.begin());
}

optimize::SolveReport solveSingle(const MotionProblem& problem,
                                  const FrameProblems& frames,
                                  int frame,
                                  const hand::HandPose& start,
                                  const MotionOptions& options,
                                  const Progress& progress) {
  HANDGRAFT_REQUIRE(frame >= 0 && frame < problem.frameCount());
  const optimize::PoseProblem single = frames.at(frame, start);
  optimize::SolveOptions solving;
  solving.starts = std::max(1, options.starts);
  solving.seed = options.seed;
  return optimize::solve(single, solving, progress);
}

Trajectory solveCausal(const MotionProblem& problem,
                       const MotionOptions& options,
                       const Progress& progress) {
  validate(problem);
  validate(options);
  Fade fade = options.fade;
  fade.looks_ahead = false;
  const FrameProblems frames(problem, fade);
  hand::HandPose rest;
  rest.q = problem.prior.cwiseMax(problem.lower).cwiseMin(problem.upper);

  Trajectory trajectory;
  trajectory.time_s = problem.time_s;
  const int fullest = fullestBegin(problem, frames);
  CausalSolver solver(problem, options);
  const bool has_contacts = !frames.presentAt(fullest).empty();
  solver.begin(has_contacts
                   ? solveSingle(problem, frames, fullest, rest, options, progress).pose
                   : rest);
  for (int k = 0; k < problem.frameCount(); ++k) {
    progress.checkpoint();
    progress.report("following contacts", static_cast<double>(k) / problem.frameCount());
    CausalSolver::Step step =
        solver.follow(problem.time_s[static_cast<std::size_t>(k)], frames.at(k, rest));
    trajectory.poses.push_back(std::move(step.pose));
    trajectory.objective.push_back(step.objective);
    trajectory.evaluations += step.evaluations;
  }
  return trajectory;
}

}  // namespace handgraft::manipulation
