#include "core/hand/posture.h"

#include <gtest/gtest.h>

#include "tests/support/small_hand.h"

namespace handgraft::hand {
namespace {

using Eigen::Vector3d;

Joint hinge(const std::string& name,
            const std::string& parent,
            const std::string& child,
            const Vector3d& axis_J,
            double lower,
            double upper) {
  Joint joint;
  joint.name = name;
  joint.type = JointType::kRevolute;
  joint.parent_link = parent;
  joint.child_link = child;
  joint.axis_J = axis_J;
  joint.X_PJ.translation() = Vector3d(0, 0, 0.03);
  joint.lower = lower;
  joint.upper = upper;
  return joint;
}

/// A finger along z that spreads about x and closes about -y, downwards by its limits.
HandModel spreadingFinger() {
  const auto bone = [](const std::string& name) {
    return Link{name,
                {{geometry::transformed(geometry::makeCylinder(0.006, 0.02),
                                        Eigen::Affine3d(Eigen::Translation3d(0, 0, 0.015))),
                  "cylinder"}},
                {}};
  };
  return {"finger",
          {{"palm", {{geometry::makeBox({0.08, 0.08, 0.02}), "box"}}, {}},
           bone("base"),
           bone("middle"),
           bone("tip")},
          {hinge("spread", "palm", "base", Vector3d::UnitX(), -0.2, 0.6),
           hinge("close", "base", "middle", Vector3d::UnitY(), -1.6, 0.1),
           hinge("curl", "middle", "tip", -Vector3d::UnitY(), -0.1, 1.2)}};
}

TEST(RelaxedPosture, StandsAThirdOfTheWayToClosed) {
  const test::SmallHand hand = test::makeSmallHand();
  const Eigen::VectorXd straight = hand.skin->qReference();
  const Eigen::VectorXd q = relaxedPosture(*hand.model, straight);
  for (Eigen::Index j = 0; j < q.size(); ++j)
    EXPECT_NEAR(q[j], straight[j] + (1.5 - straight[j]) / 3.0, 1e-12) << j;
}

TEST(RelaxedPosture, KeepsOtherJointsInTheMiddleOfTheirRange) {
  const Eigen::VectorXd q = relaxedPosture(spreadingFinger(), Eigen::Vector3d::Zero());
  EXPECT_NEAR(q[0], 0.2, 1e-12);
  EXPECT_NEAR(q[1], -1.6 / 3.0, 1e-12) << "it closes towards its lower limit";
  EXPECT_NEAR(q[2], 0.4, 1e-12);
}

TEST(RelaxedPosture, IsTheRestPoseOfAHandThatWasGivenOne) {
  const Eigen::Vector3d rest(0.1, -0.7, 0.9);
  EXPECT_EQ(relaxedPosture(spreadingFinger().withRestPose(rest), Eigen::Vector3d::Zero()),
            Eigen::VectorXd(rest));
}

}  // namespace
}  // namespace handgraft::hand
