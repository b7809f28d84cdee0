#pragma once

#include <memory>
#include <random>
#include <vector>

#include "core/manipulation/motion_problem.h"

#include "tests/core/optimize/problems.h"

namespace handgraft::test {

inline double distanceOf(const hand::HandPose& a, const hand::HandPose& b) {
  return (a.X_WH.translation() - b.X_WH.translation()).norm() +
         vectorFromRotation(a.X_WH.linear() * b.X_WH.linear().transpose()).norm() +
         (a.q - b.q).norm();
}

/// Poses that go smoothly from one to another and a little beyond: joints and the root's place
/// by a sine, its rotation about one axis.
inline std::vector<hand::HandPose> smoothPoses(const hand::HandPose& from,
                                               const hand::HandPose& to,
                                               int frames) {
  std::vector<hand::HandPose> poses;
  const Eigen::Vector3d turn =
      vectorFromRotation(to.X_WH.linear() * from.X_WH.linear().transpose());
  for (int k = 0; k < frames; ++k) {
    const double share = 0.5 - 0.5 * std::cos(3.0 * k / std::max(1, frames - 1));
    hand::HandPose pose = from;
    pose.q += share * (to.q - from.q);
    pose.X_WH.translation() += share * (to.X_WH.translation() - from.X_WH.translation());
    pose.X_WH.linear() = rotationFromVector(share * turn) * from.X_WH.linear();
    poses.push_back(pose);
  }
  return poses;
}

inline std::vector<double> framesAt(double rate, int frames) {
  std::vector<double> time_s;
  for (int k = 0; k < frames; ++k)
    time_s.push_back(k / rate);
  return time_s;
}

/// A motion that `poses` solve without rest: pairs on every link, on the object where the poses
/// put them, normals opposed; one track that is there all the time.
inline manipulation::MotionProblem reachableMotion(std::shared_ptr<const hand::HandModel> model,
                                                   const std::vector<hand::HandPose>& poses,
                                                   double rate,
                                                   std::mt19937& random) {
  manipulation::MotionProblem problem =
      manipulation::makeMotionProblem(model, framesAt(rate, static_cast<int>(poses.size())));
  problem.velocity_limit.setConstant(std::numeric_limits<double>::infinity());
  const std::vector<optimize::PointPair> pairs =
      reachableProblem(model, poses.front(), 4, random).pairs;
  manipulation::PairTrack track;
  track.end = static_cast<int>(poses.size());
  for (std::size_t k = 0; k < poses.size(); ++k) {
    manipulation::PairSpan span{static_cast<int>(k), pairs};
    const hand::LinkPoses X_OL = forwardKinematics(*model, poses[k]);
    for (optimize::PointPair& pair : span.pairs) {
      const Pose& X = X_OL[static_cast<std::size_t>(pair.link)];
      pair.p_W = X * pair.p_L;
      pair.n_W = -(X.linear() * pair.n_L);
      pair.patch = 0;
    }
    track.spans.push_back(span);
  }
  problem.tracks.push_back(track);
  problem.prior = poses.front().q;
  return problem;
}

}  // namespace handgraft::test
