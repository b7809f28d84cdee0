#include "core/hand/kinematics.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "core/base/error.h"

namespace handgraft::hand {
namespace {

/// Three links: a hinge about z, a follower hinge, a slider that follows with an offset.
HandModel makeArm() {
  std::vector<Link> links{{"l0", {}, {}}, {"l1", {}, {}}, {"l2", {}, {}}, {"l3", {}, {}}};
  std::vector<Joint> joints(3);
  for (std::size_t i = 0; i < 3; ++i) {
    joints[i].name = std::string(1, static_cast<char>('a' + i));
    joints[i].type = JointType::kRevolute;
    joints[i].parent_link = "l" + std::to_string(i);
    joints[i].child_link = "l" + std::to_string(i + 1);
    joints[i].axis_J = Eigen::Vector3d::UnitZ();
    joints[i].X_PJ.translation() = Eigen::Vector3d::UnitX();
  }
  joints[1].mimic = Mimic{"a", 2.0, 0.1};
  joints[2].type = JointType::kPrismatic;
  joints[2].axis_J = {1.0, 2.0, 2.0};
  joints[2].X_PJ.linear() =
      Eigen::AngleAxisd(0.7, Eigen::Vector3d(1.0, -1.0, 0.5).normalized()).toRotationMatrix();
  return {"arm", links, joints};
}

TEST(ForwardKinematics, AgreesWithThePlanarArm) {
  const HandModel model = makeArm();
  LinkPoses X_HL;
  const double a = 0.4;
  forwardKinematics(model, Pose::Identity(), Eigen::Vector2d(a, 0.0), X_HL);
  EXPECT_TRUE(X_HL[1].translation().isApprox(Eigen::Vector3d(1.0, 0.0, 0.0), 1e-15));
  const double b = 2.0 * a + 0.1;
  EXPECT_TRUE(X_HL[2].translation().isApprox(
      Eigen::Vector3d(1.0 + std::cos(a), std::sin(a), 0.0), 1e-15));
  EXPECT_NEAR(X_HL[2].linear()(1, 0), std::sin(a + b), 1e-15);
}

TEST(ForwardKinematics, CarriesTheRootAlong) {
  const HandModel model = makeArm();
  Pose X_WH = Pose::Identity();
  X_WH.linear() = Eigen::AngleAxisd(1.0, Eigen::Vector3d::UnitY()).toRotationMatrix();
  X_WH.translation() << 1.0, 2.0, 3.0;
  const Eigen::Vector2d q(0.3, -0.2);
  LinkPoses X_HL;
  forwardKinematics(model, Pose::Identity(), q, X_HL);
  const LinkPoses X_WL = forwardKinematics(model, {X_WH, q});
  for (std::size_t i = 0; i < X_WL.size(); ++i)
    EXPECT_TRUE((X_WH * X_HL[i]).isApprox(X_WL[i], 1e-14));
}

TEST(ForwardKinematics, RequiresOneValuePerDof) {
  const HandModel model = makeArm();
  LinkPoses X_HL;
  EXPECT_THROW(forwardKinematics(model, Pose::Identity(), Eigen::Vector3d::Zero(), X_HL),
               BrokenContract);
}

TEST(PointJacobian, MatchesCentralDifferencesThroughMimics) {
  const HandModel model = makeArm();
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (int trial = 0; trial < 20; ++trial) {
    const Eigen::Vector2d q(uniform(random), uniform(random));
    const Eigen::Vector3d p_L(uniform(random), uniform(random), uniform(random));
    LinkPoses X_HL;
    forwardKinematics(model, Pose::Identity(), q, X_HL);
    const auto J = pointJacobian(model, X_HL, 3, X_HL[3] * p_L);
    constexpr double kStep = 1e-6;
    for (int i = 0; i < 2; ++i) {
      LinkPoses ahead;
      LinkPoses behind;
      forwardKinematics(model, Pose::Identity(), q + kStep * Eigen::Vector2d::Unit(i), ahead);
      forwardKinematics(model, Pose::Identity(), q - kStep * Eigen::Vector2d::Unit(i), behind);
      const Eigen::Vector3d dp = (ahead[3] * p_L - behind[3] * p_L) / (2.0 * kStep);
      const Eigen::Vector3d w =
          vectorFromRotation(ahead[3].linear() * behind[3].linear().transpose()) /
          (2.0 * kStep);
      EXPECT_LE((J.col(i).tail<3>() - dp).norm(), 1e-8);
      EXPECT_LE((J.col(i).head<3>() - w).norm(), 1e-8);
    }
  }
}

}  // namespace
}  // namespace handgraft::hand
