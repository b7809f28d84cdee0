#include "core/manipulation/trajectory.h"

#include <algorithm>
#include <cmath>

#include "core/base/angle.h"
#include "core/base/error.h"

namespace handgraft::manipulation {

namespace {

/// Derivative of a series of vectors, each at the middle of two of its times.
struct Series {
  std::vector<double> time_s;
  std::vector<Eigen::VectorXd> values;

  [[nodiscard]] Series derivative() const {
    Series rate;
    for (std::size_t k = 1; k < values.size(); ++k) {
      rate.time_s.push_back(0.5 * (time_s[k - 1] + time_s[k]));
      rate.values.emplace_back((values[k] - values[k - 1]) / (time_s[k] - time_s[k - 1]));
    }
    return rate;
  }

  [[nodiscard]] double largest() const {
    double most = 0.0;
    for (const Eigen::VectorXd& value : values)
      if (value.size() != 0) most = std::max(most, value.cwiseAbs().maxCoeff());
    return most;
  }

  [[nodiscard]] double largestShareOf(const Eigen::VectorXd& limits) const {
    double most = 0.0;
    for (const Eigen::VectorXd& value : values)
      if (value.size() != 0)
        most = std::max(most, (value.cwiseAbs().array() / limits.array()).maxCoeff());
    return most;
  }
};

}  // namespace

hand::HandPose poseBetween(const hand::HandPose& from, const hand::HandPose& to, double share) {
  hand::HandPose pose = from;
  pose.q += share * (to.q - from.q);
  pose.X_WH.translation() += share * (to.X_WH.translation() - from.X_WH.translation());
  const Eigen::Vector3d turn =
      vectorFromRotation(to.X_WH.linear() * from.X_WH.linear().transpose());
  pose.X_WH.linear() = rotationFromVector(share * turn) * from.X_WH.linear();
  return pose;
}

Smoothness measureSmoothness(const MotionProblem& problem,
                             const std::vector<hand::HandPose>& poses) {
  HANDGRAFT_REQUIRE(poses.size() == problem.time_s.size());
  Series places{problem.time_s, {}};
  for (const hand::HandPose& pose : poses)
    places.values.push_back(pose.q);
  Smoothness smoothness;
  for (std::size_t k = 1; k < poses.size(); ++k)
    if (poses[k].q.size() != 0)
      smoothness.max_step =
          std::max(smoothness.max_step, (poses[k].q - poses[k - 1].q).cwiseAbs().maxCoeff());
  const Series velocity = places.derivative();
  const Series acceleration = velocity.derivative();
  const Series jerk = acceleration.derivative();
  smoothness.max_velocity = velocity.largest();
  smoothness.max_acceleration = acceleration.largest();
  smoothness.velocity_share = velocity.largestShareOf(problem.velocity_limit);
  smoothness.acceleration_share = acceleration.largestShareOf(problem.acceleration_limit);
  double sum = 0.0;
  Eigen::Index count = 0;
  for (const Eigen::VectorXd& value : jerk.values) {
    sum += value.squaredNorm();
    count += value.size();
  }
  if (count > 0) smoothness.rms_jerk = std::sqrt(sum / static_cast<double>(count));
  return smoothness;
}

double limitShareAt(const MotionProblem& problem,
                    const std::vector<hand::HandPose>& poses,
                    std::size_t k) {
  const auto velocity = [&](std::size_t behind, Eigen::Index joint) {
    return (poses[behind].q[joint] - poses[behind - 1].q[joint]) /
           (problem.time_s[behind] - problem.time_s[behind - 1]);
  };
  double share = 0.0;
  for (Eigen::Index i = 0; k >= 1 && i < poses[k].q.size(); ++i) {
    const double now = velocity(k, i);
    share = std::max(share, std::abs(now) / problem.velocity_limit[i]);
    if (k < 2) continue;
    const double between = 0.5 * (problem.time_s[k] - problem.time_s[k - 2]);
    share = std::max(
        share, std::abs(now - velocity(k - 1, i)) / between / problem.acceleration_limit[i]);
  }
  return share;
}

std::vector<FrameFit> fitFrames(const MotionProblem& problem,
                                const std::vector<hand::HandPose>& poses) {
  HANDGRAFT_REQUIRE(poses.size() == problem.time_s.size());
  const FrameProblems frames(problem, Fade{0.0, true});
  std::vector<FrameFit> fits(poses.size());
  hand::LinkPoses X_OL;
  for (std::size_t k = 0; k < poses.size(); ++k) {
    const optimize::PoseProblem single = frames.at(static_cast<int>(k), poses[k]);
    hand::forwardKinematics(*problem.model, poses[k].X_WH, poses[k].q, X_OL);
    FrameFit& fit = fits[k];
    for (const optimize::PointPair& pair : single.pairs) {
      // Neither a place that is held nor a patch that is switched off.
      if (pair.patch < 0 || pair.weight == 0.0) continue;
      const Pose& X = X_OL[static_cast<std::size_t>(pair.link)];
      fit.mean_mm += 1e3 * (X * pair.p_L - pair.p_W).norm();
      ++fit.points;
      if (!pair.has_normals) continue;
      const double cosine = -(X.linear() * pair.n_L).dot(pair.n_W);
      fit.normal_deg += inDegrees(std::acos(std::clamp(cosine, -1.0, 1.0)));
      ++fit.normals;
    }
    if (fit.points > 0) fit.mean_mm /= fit.points;
    if (fit.normals > 0) fit.normal_deg /= fit.normals;
  }
  return fits;
}

FrameFit meanFit(const std::vector<FrameFit>& frames) {
  FrameFit all;
  for (const FrameFit& fit : frames) {
    all.points += fit.points;
    all.normals += fit.normals;
    all.mean_mm += fit.points * fit.mean_mm;
    all.normal_deg += fit.normals * fit.normal_deg;
  }
  if (all.points > 0) all.mean_mm /= all.points;
  if (all.normals > 0) all.normal_deg /= all.normals;
  return all;
}

}  // namespace handgraft::manipulation
