#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "core/hand/hand_model.h"
#include "core/hand/kinematics.h"
#include "core/hand/skin.h"

namespace handgraft::test {

struct BallHand {
  std::shared_ptr<const hand::HandModel> model;
  std::shared_ptr<const hand::Skin> skin;
};

/// A hand's kinematics with a ball about the origin of every link; the skin is the balls.
inline BallHand withBalls(const hand::HandModel& bare, double radius_m) {
  std::vector<hand::Link> links = bare.links();
  for (hand::Link& link : links)
    link.visuals = {{geometry::makeSphere(radius_m, 4), "ball"}};
  BallHand hand;
  hand.model = std::make_shared<const hand::HandModel>(bare.name(), links, bare.joints());
  const Eigen::VectorXd q = hand.model->restPose();
  hand::LinkPoses X_SL;
  hand::forwardKinematics(*hand.model, Pose::Identity(), q, X_SL);
  std::vector<geometry::TriangleMesh> balls;
  for (const Pose& X : X_SL)
    balls.push_back(
        geometry::transformed(links[0].visuals[0].mesh_L, Eigen::Affine3d(X.matrix())));
  hand.skin =
      std::make_shared<const hand::Skin>(*hand.model, geometry::merged(balls), q, 0.004);
  return hand;
}

}  // namespace handgraft::test
