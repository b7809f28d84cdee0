#include "tests/core/optimize/problems.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace handgraft::test {

namespace {

using hand::Joint;
using hand::JointType;

double uniform(std::mt19937& random, double lower, double upper) {
  // By hand: the standard's distributions differ between libraries.
  return lower + (upper - lower) * (static_cast<double>(random()) / 4294967296.0);
}

Eigen::Vector3d randomVector(std::mt19937& random, double reach) {
  const double x = uniform(random, -reach, reach);
  const double y = uniform(random, -reach, reach);
  return {x, y, uniform(random, -reach, reach)};
}

Joint joint(const std::string& name,
            JointType type,
            const std::string& parent,
            const std::string& child,
            const Eigen::Vector3d& position,
            const Eigen::Vector3d& turn,
            const Eigen::Vector3d& axis) {
  Joint j;
  j.name = name;
  j.type = type;
  j.parent_link = parent;
  j.child_link = child;
  j.X_PJ.linear() = rotationFromVector(turn);
  j.X_PJ.translation() = position;
  j.axis_J = axis.normalized();
  return j;
}

std::vector<hand::Link> links(const std::vector<std::string>& names) {
  std::vector<hand::Link> result;
  for (const std::string& name : names) {
    hand::Link link;
    link.name = name;
    result.push_back(link);
  }
  return result;
}

}  // namespace

std::shared_ptr<const hand::HandModel> syntheticHand() {
  std::vector<Joint> joints;
  joints.push_back(joint("a1", JointType::kRevolute, "palm", "a_proximal", {0.02, 0.01, 0.08},
                         {0.3, -0.2, 0.1}, {1, 0, 0}));
  joints.push_back(joint("a2", JointType::kRevolute, "a_proximal", "a_distal", {0, 0, 0.04},
                         {0, 0.1, 0}, {1, 0.2, 0}));
  joints.push_back(joint("a_tip", JointType::kFixed, "a_distal", "a_tip", {0, 0, 0.03},
                         {0, 0, 0}, {1, 0, 0}));
  joints.push_back(joint("b1", JointType::kRevolute, "palm", "b_base", {-0.03, 0, 0.05},
                         {0, 0, 1.2}, {0, 0, 1}));
  joints.push_back(joint("b2", JointType::kPrismatic, "b_base", "b_slider", {0.01, 0, 0.02},
                         {0.4, 0, 0}, {0, 1, 1}));
  joints.push_back(joint("b3", JointType::kRevolute, "b_slider", "b_tip", {0, 0.02, 0.03},
                         {0, -0.5, 0}, {0, 1, 0}));
  joints[0].lower = -0.3;
  joints[0].upper = 1.6;
  joints[1].mimic = hand::Mimic{"a1", 0.7, 0.1};
  joints[4].lower = -0.01;
  joints[4].upper = 0.02;
  joints[5].lower = 0.0;
  joints[5].upper = 1.2;
  return std::make_shared<const hand::HandModel>(
      "synthetic",
      links({"palm", "a_proximal", "a_distal", "a_tip", "b_base", "b_slider", "b_tip"}),
      joints);
}

std::shared_ptr<const hand::HandModel> rigidHand() {
  return std::make_shared<const hand::HandModel>("rigid", links({"palm"}),
                                                 std::vector<Joint>());
}

hand::HandPose moved(hand::HandPose pose, int dof, double step) {
  if (dof < 3) {
    pose.X_WH.linear() =
        rotationFromVector(step * Eigen::Vector3d::Unit(dof)) * pose.X_WH.linear();
  } else if (dof < 6) {
    pose.X_WH.translation()[dof - 3] += step;
  } else {
    pose.q[dof - 6] += step;
  }
  return pose;
}

Eigen::Vector3d randomUnit(std::mt19937& random) {
  for (;;) {
    const Eigen::Vector3d v = randomVector(random, 1.0);
    if (v.norm() > 0.1 && v.norm() < 1.0) return v.normalized();
  }
}

hand::HandPose randomPose(const hand::HandModel& model, std::mt19937& random) {
  hand::HandPose pose;
  const double angle = uniform(random, 0.0, std::numbers::pi);
  pose.X_WH.linear() = rotationFromVector(angle * randomUnit(random));
  pose.X_WH.translation() = randomVector(random, 0.5);
  pose.q.resize(model.dofCount());
  for (int j = 0; j < model.dofCount(); ++j) {
    const double lower = std::max(model.lower()[j], -std::numbers::pi);
    const double upper = std::min(model.upper()[j], std::numbers::pi);
    pose.q[j] = uniform(random, lower, upper);
  }
  return pose;
}

optimize::PoseProblem randomProblem(std::shared_ptr<const hand::HandModel> model,
                                    int count,
                                    std::mt19937& random) {
  optimize::PoseProblem problem = optimize::makeProblem(std::move(model));
  problem.prior = randomPose(*problem.model, random);
  problem.weights.prior = 0.3;
  problem.prior_weights.resize(problem.dofCount());
  for (double& weight : problem.prior_weights)
    weight = uniform(random, 0.1, 2.0);
  for (int i = 0; i < count; ++i) {
    optimize::PointPair pair;
    pair.link = static_cast<int>(random() % static_cast<unsigned>(problem.model->linkCount()));
    pair.p_L = randomVector(random, 0.03);
    pair.n_L = randomUnit(random);
    pair.p_W = randomVector(random, 0.3);
    pair.n_W = randomUnit(random);
    pair.weight = uniform(random, 0.2, 3.0);
    pair.patch = i % 3;
    problem.pairs.push_back(pair);
  }
  return problem;
}

optimize::PoseProblem reachableProblem(std::shared_ptr<const hand::HandModel> model,
                                       const hand::HandPose& goal,
                                       int pairs_per_link,
                                       std::mt19937& random) {
  optimize::PoseProblem problem = optimize::makeProblem(std::move(model));
  problem.weights.prior = 0.0;
  const hand::LinkPoses X_WL = forwardKinematics(*problem.model, goal);
  for (int link = 0; link < problem.model->linkCount(); ++link) {
    for (int i = 0; i < pairs_per_link; ++i) {
      const Pose& X = X_WL[static_cast<std::size_t>(link)];
      optimize::PointPair pair;
      pair.link = link;
      pair.p_L = randomVector(random, 0.02);
      pair.n_L = randomUnit(random);
      pair.p_W = X * pair.p_L;
      pair.n_W = -(X.linear() * pair.n_L);
      pair.patch = link;
      problem.pairs.push_back(pair);
    }
  }
  return problem;
}

std::vector<std::string> realHands() {
  return {"hands/allegro_right/allegro_hand_right.urdf",
          "hands/barrett_bhand/bhand_model.urdf",
          "hands/human_hand_graspit20/human_hand_graspit20.urdf",
          "hands/mano_mean/mano_mean_fixed.urdf",
          "hands/mia_hand_right/mia_hand_description/urdf/mia_hand.urdf",
          "problems/allegro_mjcf.urdf",
          "problems/human_hand20.urdf"};
}

}  // namespace handgraft::test
