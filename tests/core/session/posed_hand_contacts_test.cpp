#include "core/session/posed_hand_contacts.h"

#include <gtest/gtest.h>

#include "tests/support/plate_hand.h"
#include "tests/support/plates.h"

namespace handgraft::session {
namespace {

TEST(PosedSurfaces, StandWhereThePosePutsThemSeenFromTheObject) {
  const auto hand = test::makeRigidHand(test::makePlate(2, 2, 0.01));
  hand::HandPose pose;
  pose.q = Eigen::VectorXd(0);
  pose.X_WH.translate(Eigen::Vector3d(0.1, 0.2, 0.3));
  Pose X_WO = Pose::Identity();
  X_WO.translate(Eigen::Vector3d(0.0, 0.2, 0.3));
  X_WO.rotate(Eigen::AngleAxisd(0.5 * 3.14159265358979323846, Eigen::Vector3d::UnitZ()));
  const auto parts = posedSurfaces(*hand, pose, X_WO);
  ASSERT_EQ(parts.size(), 1u);
  EXPECT_EQ(parts[0].name, "plate");
  // The link's origin, the plate's middle vertex, lies 0.1 m along the world's x: -y of O.
  EXPECT_LT((parts[0].mesh_O.vertex(4) - Eigen::Vector3d(0.0, -0.1, 0.0)).norm(), 1e-12);
  EXPECT_NEAR(parts[0].mesh_O.area(), 4e-4, 1e-12);
}

TEST(PosedSurfaces, LeaveOutLinksWithoutOne) {
  hand::Link bare;
  bare.name = "frame";
  const hand::HandModel hand("bare", {bare}, {});
  EXPECT_TRUE(
      posedSurfaces(hand, {Pose::Identity(), Eigen::VectorXd(0)}, Pose::Identity()).empty());
}

}  // namespace
}  // namespace handgraft::session
