#include "core/hand/mirror.h"

#include <gtest/gtest.h>

#include "core/hand/kinematics.h"

#include "tests/support/small_hand.h"

namespace handgraft::hand {
namespace {

/// A small hand without any symmetry of its own: every frame turned, one joint a slider.
HandModel crookedHand() {
  const HandModel small = *test::makeSmallHand().model;
  std::vector<Joint> joints = small.joints();
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const double t = 0.3 + 0.1 * static_cast<double>(i);
    joints[i].X_PJ.linear() = rotationFromVector(Eigen::Vector3d(t, -0.2, 0.5 * t));
    joints[i].axis_J = Eigen::Vector3d(1.0, t, -0.4).normalized();
  }
  joints.back().type = JointType::kPrismatic;
  return {"crooked", small.links(), joints};
}

TEST(Mirror, MovesAsTheReflectionOfTheHand) {
  const HandModel right = crookedHand();
  const HandModel left = mirrored(right, "left");
  EXPECT_EQ(left.name(), "left");
  EXPECT_EQ(left.dofNames(), right.dofNames());
  EXPECT_EQ(left.lower(), right.lower());
  const Eigen::DiagonalMatrix<double, 3> S(-1.0, 1.0, 1.0);
  Eigen::VectorXd q(right.dofCount());
  for (int i = 0; i < q.size(); ++i)
    q[i] = 0.9 - 0.37 * i;
  const LinkPoses pose_right = forwardKinematics(right, {Pose::Identity(), q});
  const LinkPoses pose_left = forwardKinematics(left, {Pose::Identity(), q});
  for (std::size_t link = 0; link < pose_right.size(); ++link) {
    const Eigen::Matrix3d R = S * pose_right[link].linear() * S;
    EXPECT_TRUE(pose_left[link].linear().isApprox(R, 1e-12)) << link;
    EXPECT_LT((pose_left[link].translation() - S * pose_right[link].translation()).norm(),
              1e-14);
    const auto& shapes_right = right.links()[link].visuals;
    const auto& shapes_left = left.links()[link].visuals;
    ASSERT_EQ(shapes_left.size(), shapes_right.size());
    for (std::size_t s = 0; s < shapes_left.size(); ++s) {
      const auto& mesh_right = shapes_right[s].mesh_L;
      const auto& mesh_left = shapes_left[s].mesh_L;
      // The same point of the surface, seen in the mirror, and still facing outwards.
      EXPECT_LT((mesh_left.vertices() - S * mesh_right.vertices()).cwiseAbs().maxCoeff(),
                1e-15);
      EXPECT_LT((mesh_left.faceNormals() - S * mesh_right.faceNormals()).cwiseAbs().maxCoeff(),
                1e-9);
    }
  }
}

TEST(Mirror, KeepsTheRestPose) {
  const HandModel right = crookedHand();
  const Eigen::VectorXd q =
      right.zeroPose().cwiseMax(0.01).cwiseMin(right.upper()).cwiseMax(right.lower());
  ASSERT_NE(q, right.zeroPose());
  EXPECT_EQ(mirrored(right.withRestPose(q), "left").restPose(), q);
}

TEST(Mirror, TwiceIsTheSameHand) {
  const HandModel right = crookedHand();
  const HandModel again = mirrored(mirrored(right, "left"), right.name());
  for (std::size_t i = 0; i < right.joints().size(); ++i) {
    EXPECT_TRUE(again.joints()[i].X_PJ.isApprox(right.joints()[i].X_PJ, 1e-15));
    EXPECT_EQ(again.joints()[i].axis_J, right.joints()[i].axis_J);
  }
  EXPECT_TRUE(mirrored(right, "left").isMirror());
  EXPECT_FALSE(again.isMirror()) << "its names are its own";
  EXPECT_EQ(again.links()[0].visuals[0].mesh_L.vertices(),
            right.links()[0].visuals[0].mesh_L.vertices());
}

}  // namespace
}  // namespace handgraft::hand
