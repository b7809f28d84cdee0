#include "core/retargeting/hand_goal.h"

namespace handgraft::retargeting {

std::vector<optimize::PointPair> pairsTo(const hand::HandModel& model,
                                         const hand::HandPose& goal,
                                         double weight) {
  constexpr double kAside = 0.03;  // m
  const hand::LinkPoses X_WL = forwardKinematics(model, goal);
  std::vector<optimize::PointPair> pairs;
  pairs.reserve(3 * X_WL.size());
  for (std::size_t link = 0; link < X_WL.size(); ++link) {
    for (const Eigen::Vector3d& p_L :
         {Eigen::Vector3d(Eigen::Vector3d::Zero()), Eigen::Vector3d(kAside, 0.0, 0.0),
          Eigen::Vector3d(0.0, kAside, 0.0)}) {
      optimize::PointPair pair;
      pair.link = static_cast<int>(link);
      pair.p_L = p_L;
      pair.p_W = X_WL[link] * p_L;
      pair.has_normals = false;
      pair.weight = weight;
      pairs.push_back(pair);
    }
  }
  return pairs;
}

}  // namespace handgraft::retargeting
