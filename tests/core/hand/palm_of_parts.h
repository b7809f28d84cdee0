#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tests/support/ball_hand.h"

namespace handgraft::test {

/// A palm and two balls on it, by a hinge each, one of them by way of a link fixed to it; the
/// palm's mesh has further balls within.
inline BallHand palmOfParts(double radius_m) {
  std::vector<hand::Link> links(4);
  std::vector<hand::Joint> joints;
  const auto hang = [&](std::size_t child, std::size_t parent, hand::JointType type, double x) {
    hand::Joint joint;
    joint.name = "joint" + std::to_string(child);
    joint.type = type;
    joint.parent_link = links[parent].name;
    joint.child_link = links[child].name;
    joint.X_PJ.translation() = Eigen::Vector3d(x, 0, 0);
    joint.axis_J = Eigen::Vector3d::UnitZ();
    joint.lower = -3.0;
    joint.upper = 3.0;
    joints.push_back(joint);
  };
  for (std::size_t i = 0; i < links.size(); ++i)
    links[i].name = "link" + std::to_string(i);
  hang(1, 0, hand::JointType::kRevolute, -0.03);
  hang(2, 0, hand::JointType::kFixed, 0.03);
  hang(3, 2, hand::JointType::kRevolute, 0.03);
  BallHand hand = withBalls(hand::HandModel("palm", links, joints), radius_m);
  links = hand.model->links();
  const geometry::TriangleMesh ball = links[0].visuals[0].mesh_L;
  std::vector<geometry::TriangleMesh> parts = {ball};
  for (const double share : {0.8, 0.6, 0.4, 0.2})
    parts.push_back(geometry::transformed(ball, Eigen::Affine3d(Eigen::Scaling(share))));
  links[0].visuals[0].mesh_L = geometry::merged(parts);
  const Eigen::VectorXd q = hand.model->restPose();
  hand.model = std::make_shared<const hand::HandModel>("palm", links, joints);
  hand.skin = std::make_shared<const hand::Skin>(*hand.model, hand.skin->mesh(), q, 0.004);
  return hand;
}

}  // namespace handgraft::test
