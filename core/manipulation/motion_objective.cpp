#include "core/manipulation/motion_objective.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/base/error.h"

namespace handgraft::manipulation {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

// Of the square of what goes beyond a limit in 1/120 s: a joint that would gain a centimetre of
// a patch stays within a percent of its limit.
constexpr double kLimitWeight = 4e6;
constexpr double kLimitShare = 0.98;  // of a limit, where it begins to cost

/// Weights of two steps in a second difference: behind * (x2 - x1) - before * (x1 - x0).
struct Difference {
  double before = 0.0;
  double behind = 0.0;
};

Difference differenceAt(const std::vector<double>& time_s, std::size_t middle) {
  const double first = time_s[middle] - time_s[middle - 1];
  const double second = time_s[middle + 1] - time_s[middle];
  const double scale = 2.0 * kReferenceStep * kReferenceStep / (first + second);
  return {scale / first, scale / second};
}

/// Of |first difference|^2, beside that of second differences: what nothing holds comes to rest
/// in about this time, as minima of |x''|^2 + |x'|^2 / tau^2 do.
constexpr double settlingShare() {
  constexpr double kFrames = kSettling / kReferenceStep;
  return 1.0 / (kFrames * kFrames);
}

Vector3d turnBetween(const hand::HandPose& a, const hand::HandPose& b) {
  return vectorFromRotation(b.X_WH.linear() * a.X_WH.linear().transpose());
}

/// How far x lies beyond [-limit, limit], with its sign.
double beyond(double x, double limit) {
  if (x > limit) return x - limit;
  return x < -limit ? x + limit : 0.0;
}

/// Whether a frame has other pairs than its tracks give it.
bool hasPairsOfOwn(const MotionProblem& problem, int frame) {
  const auto own = problem.own.find(frame);
  return own != problem.own.end() && !(own->second.pairs.empty() && own->second.shares.empty());
}

/// Whether a frame has the same contacts as one before: the same moments, then.
bool hasContactsOf(const MotionProblem& problem,
                   const FrameProblems& frames,
                   int earlier,
                   int frame) {
  if (hasPairsOfOwn(problem, frame) || hasPairsOfOwn(problem, earlier)) return false;
  const auto& now = frames.presentAt(frame);
  const auto& before = frames.presentAt(earlier);
  if (now.size() != before.size()) return false;
  for (std::size_t i = 0; i < now.size(); ++i) {
    if (now[i].track != before[i].track || now[i].presence != before[i].presence) return false;
    for (const PairSpan& span : problem.tracks[static_cast<std::size_t>(now[i].track)].spans)
      if (span.begin > earlier && span.begin <= frame) return false;
  }
  return true;
}

std::vector<int> allFrames(const MotionProblem& problem) {
  std::vector<int> frames(problem.time_s.size());
  std::iota(frames.begin(), frames.end(), 0);
  return frames;
}

/// Neighbouring frames, and their shares in a difference of what they have: r = sum of
/// share * x.
template <int kCount>
struct FrameDifference {
  std::size_t first;
  double shares[kCount];

  /// weight r^2, of one degree of freedom that is no turn.
  void add(Eigen::Index dof, double residual, double weight, BandSystem& system) const {
    for (int i = 0; i < kCount; ++i) {
      const std::size_t a = first + static_cast<std::size_t>(i);
      system.right[a][dof] -= 2.0 * weight * shares[i] * residual;
      system.own[a](dof, dof) += 2.0 * weight * shares[i] * shares[i];
      if (i + 1 < kCount)
        system.next[a].others[dof - 3] += 2.0 * weight * shares[i] * shares[i + 1];
      if (i + 2 < kCount)
        system.after_next[a].others[dof - 3] += 2.0 * weight * shares[i] * shares[i + 2];
    }
  }
};

}  // namespace

MotionObjective::MotionObjective(const MotionProblem& problem,
                                 const MotionOptions& options,
                                 optimize::WorkerPool& pool)
    : MotionObjective(
          problem, FrameProblems(problem, options.fade), options, pool, allFrames(problem)) {}

MotionObjective::MotionObjective(const MotionProblem& problem,
                                 const FrameProblems& problems,
                                 const MotionOptions& options,
                                 optimize::WorkerPool& pool,
                                 const std::vector<int>& frames)
    : problem_(problem), pool_(pool), bare_(frames.size()), trees_(frames.size()) {
  HANDGRAFT_REQUIRE(!frames.empty() && frames.front() >= 0 &&
                    frames.back() < problem.frameCount());
  for (const int frame : frames)
    time_s_.push_back(problem.time_s[static_cast<std::size_t>(frame)]);
  hand::HandPose rest;
  rest.q = problem.prior;
  for (std::size_t k = 0; k < trees_.size(); ++k) {
    const int frame = frames[k];
    trees_[k] = k > 0 && hasContactsOf(problem, problems, frames[k - 1], frame)
                    ? trees_[k - 1]
                    : std::make_shared<const optimize::MomentTree>(
                          makeMomentTree(problems.at(frame, rest)));
  }
  const auto bare_at = [&](std::size_t k) {
    optimize::PoseProblem bare = problems.at(frames[k], rest);
    bare.pairs.clear();
    return std::make_shared<const optimize::PoseProblem>(std::move(bare));
  };
  std::shared_ptr<const optimize::PoseProblem> plain;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    if (!problem.turns.empty() || problem.own.count(frames[k]) != 0) {
      bare_[k] = bare_at(k);
    } else {
      if (!plain) plain = bare_at(k);
      bare_[k] = plain;
    }
  }
  smoothness_ = VectorXd::Constant(dofCount(), options.smoothness);
  smoothness_.head<3>() *= kTurnScale;
  smoothness_.segment<3>(3) *= kShiftScale;
  for (int i = 0; i < problem.model->dofCount(); ++i)
    if (problem.model->dofJoint(i).type == hand::JointType::kPrismatic)
      smoothness_[6 + i] *= kSliderScale;
  whole_smoothness_ = smoothness_;
  frames_.assign(trees_.size(), 0.0);
  models_.resize(trees_.size());
  seen_.resize(trees_.size());
  near_.resize(trees_.size());
}

void MotionObjective::join(double smoothness, double limits) {
  smoothness_ = smoothness * whole_smoothness_;
  limit_share_ = limits;
}

double MotionObjective::evaluate(const Poses& poses) {
  return evaluate(poses, false);
}

double MotionObjective::evaluateToExpand(const Poses& poses) {
  return evaluate(poses, true);
}

double MotionObjective::evaluate(const Poses& poses, bool to_expand) {
  HANDGRAFT_REQUIRE(poses.size() == trees_.size());
  pool_.run(static_cast<int>(poses.size()), [&](int, int k) {
    const auto index = static_cast<std::size_t>(k);
    optimize::Objective objective(*bare_[index], trees_[index]);
    objective.level(level_);
    objective.swapNear(near_[index]);
    frames_[index] = objective.evaluate(poses[index]).objective;
    if (to_expand) modelFrame(objective, seen_[index]);
    objective.swapNear(near_[index]);
  });
  double sum = joining(poses);
  for (const double frame : frames_)
    sum += frame;
  return sum;
}

void MotionObjective::modelFrame(optimize::Objective& objective, FrameModel& own) const {
  optimize::QuadraticModel model(dofCount());
  objective.expand(model);
  own.gradient = model.gradient;
  own.scale = model.gauss_newton.diagonal();
  own.hessian = model.gauss_newton + model.residual_curvature;
  // Joints that no contact moves must not spoil the test.
  Eigen::MatrixXd tested = own.hessian;
  tested.diagonal().array() += 1e-9 * own.scale.maxCoeff();
  if (tested.llt().info() != Eigen::Success) own.hessian = model.gauss_newton;
}

void MotionObjective::expand(const Poses& poses, BandSystem& system) {
  HANDGRAFT_REQUIRE(poses.size() == trees_.size() && system.own.size() == trees_.size());
  for (Coupling& coupling : system.next)
    coupling.reset();
  for (Coupling& coupling : system.after_next)
    coupling.reset();
  for (std::size_t k = 0; k < models_.size(); ++k) {
    system.right[k] = -models_[k].gradient;
    system.own[k] = models_[k].hessian;
  }
  addFirstDifferences(poses, system);
  addSecondDifferences(poses, system);
}

double MotionObjective::joining(const Poses& poses) const {
  const auto& time_s = time_s_;
  const double limit_weight = limit_share_ * kLimitWeight;
  const double settling = settlingShare();
  double sum = 0.0;
  for (std::size_t k = 1; k < poses.size(); ++k) {
    const double step = time_s[k] - time_s[k - 1];
    const double rate = kReferenceStep / step;
    const hand::HandPose& a = poses[k - 1];
    const hand::HandPose& b = poses[k];
    sum += rate * rate * settling *
           (smoothness_[0] * turnBetween(a, b).squaredNorm() +
            smoothness_[3] * (b.X_WH.translation() - a.X_WH.translation()).squaredNorm() +
            smoothness_.tail(b.q.size()).dot((b.q - a.q).cwiseAbs2()));
    for (Eigen::Index i = 0; i < poses[k].q.size(); ++i) {
      const double limit = kLimitShare * problem_.velocity_limit[i];
      const double excess = beyond((poses[k].q[i] - poses[k - 1].q[i]) / step, limit);
      sum += limit_weight * excess * excess * kReferenceStep * kReferenceStep;
    }
  }
  const double square = kReferenceStep * kReferenceStep;
  for (std::size_t k = 1; k + 1 < poses.size(); ++k) {
    const Difference d = differenceAt(time_s, k);
    const hand::HandPose& a = poses[k - 1];
    const hand::HandPose& b = poses[k];
    const hand::HandPose& c = poses[k + 1];
    const Vector3d turn = d.behind * turnBetween(b, c) - d.before * turnBetween(a, b);
    const Vector3d shift = d.behind * (c.X_WH.translation() - b.X_WH.translation()) -
                           d.before * (b.X_WH.translation() - a.X_WH.translation());
    sum += smoothness_[0] * turn.squaredNorm() + smoothness_[3] * shift.squaredNorm();
    for (Eigen::Index i = 0; i < b.q.size(); ++i) {
      const double bend = d.behind * (c.q[i] - b.q[i]) - d.before * (b.q[i] - a.q[i]);
      const double excess = beyond(bend, kLimitShare * problem_.acceleration_limit[i] * square);
      sum += smoothness_[6 + i] * bend * bend + limit_weight * excess * excess;
    }
  }
  return sum;
}

void MotionObjective::addFirstDifferences(const Poses& poses, BandSystem& system) const {
  const double limit_weight = limit_share_ * kLimitWeight;
  const double settling = settlingShare();
  for (std::size_t k = 1; k < poses.size(); ++k) {
    const double rate = kReferenceStep / (time_s_[k] - time_s_[k - 1]);
    const FrameDifference<2> difference{k - 1, {-rate, rate}};
    const hand::HandPose& a = poses[k - 1];
    const hand::HandPose& b = poses[k];
    for (int i = 0; i < 3; ++i) {
      const double way = rate * (b.X_WH.translation()[i] - a.X_WH.translation()[i]);
      difference.add(3 + i, way, settling * smoothness_[3 + i], system);
    }
    const Vector3d turn = rate * turnBetween(a, b);
    const Matrix3d J = rate * leftJacobianInverse(turnBetween(a, b));
    const double two_w = 2.0 * settling * smoothness_[0];
    system.right[k - 1].head<3>() += two_w * J * turn;
    system.right[k].head<3>() -= two_w * J.transpose() * turn;
    system.own[k - 1].topLeftCorner<3, 3>() += two_w * J * J.transpose();
    system.own[k].topLeftCorner<3, 3>() += two_w * J.transpose() * J;
    system.next[k - 1].turn -= two_w * J.transpose() * J.transpose();
    for (Eigen::Index i = 0; i < poses[k].q.size(); ++i) {
      const double way = rate * (poses[k].q[i] - poses[k - 1].q[i]);
      const double excess =
          beyond(way, kLimitShare * problem_.velocity_limit[i] * kReferenceStep);
      difference.add(6 + i, way, settling * smoothness_[6 + i], system);
      if (excess != 0.0) difference.add(6 + i, excess, limit_weight, system);
    }
  }
}

void MotionObjective::addSecondDifferences(const Poses& poses, BandSystem& system) const {
  const double limit_weight = limit_share_ * kLimitWeight;
  const double square = kReferenceStep * kReferenceStep;
  for (std::size_t k = 1; k + 1 < poses.size(); ++k) {
    const Difference d = differenceAt(time_s_, k);
    const FrameDifference<3> difference{k - 1, {d.before, -d.before - d.behind, d.behind}};
    const auto& shares = difference.shares;
    const hand::HandPose& a = poses[k - 1];
    const hand::HandPose& b = poses[k];
    const hand::HandPose& c = poses[k + 1];
    for (int i = 0; i < 3; ++i) {
      const double bend = shares[0] * a.X_WH.translation()[i] +
                          shares[1] * b.X_WH.translation()[i] +
                          shares[2] * c.X_WH.translation()[i];
      difference.add(3 + i, bend, smoothness_[3 + i], system);
    }
    for (Eigen::Index i = 0; i < b.q.size(); ++i) {
      const double bend = shares[0] * a.q[i] + shares[1] * b.q[i] + shares[2] * c.q[i];
      difference.add(6 + i, bend, smoothness_[6 + i], system);
      const double excess = beyond(bend, kLimitShare * problem_.acceleration_limit[i] * square);
      if (excess != 0.0) difference.add(6 + i, excess, limit_weight, system);
    }
    // log(R_b R_a^T) follows turns w_a, w_b by J^-1 w_b - J^-T w_a, J its left Jacobian.
    const Vector3d first = turnBetween(a, b);
    const Vector3d second = turnBetween(b, c);
    const Matrix3d first_jacobian = leftJacobianInverse(first);
    const Matrix3d second_jacobian = leftJacobianInverse(second);
    const Vector3d turn = d.behind * second - d.before * first;
    const Matrix3d by[3] = {d.before * first_jacobian.transpose(),
                            -d.behind * second_jacobian.transpose() - d.before * first_jacobian,
                            d.behind * second_jacobian};
    const double two_w = 2.0 * smoothness_[0];
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t frame = k - 1 + i;
      system.right[frame].head<3>() -= two_w * by[i].transpose() * turn;
      system.own[frame].topLeftCorner<3, 3>() += two_w * by[i].transpose() * by[i];
      if (i < 2) system.next[frame].turn += two_w * by[i + 1].transpose() * by[i];
      if (i < 1) system.after_next[frame].turn += two_w * by[i + 2].transpose() * by[i];
    }
  }
}

void moveBy(const MotionProblem& problem,
            const std::vector<int>& frames,
            const std::vector<VectorXd>& steps,
            const std::vector<hand::HandPose>& from,
            std::vector<hand::HandPose>& to) {
  to = from;
  for (std::size_t k = 0; k < steps.size(); ++k) {
    const VectorXd& step = steps[k];
    hand::HandPose& pose = to[k];
    pose.X_WH.linear() = rotationFromVector(step.head<3>()) * from[k].X_WH.linear();
    pose.X_WH.translation() += step.segment<3>(3);
    pose.q += step.tail(step.size() - 6);
    const int frame = frames[k];
    pose.q = pose.q.cwiseMax(problem.lowerAt(frame)).cwiseMin(problem.upperAt(frame));
  }
}

}  // namespace handgraft::manipulation
