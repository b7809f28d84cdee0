#include "core/hand/floating_base.h"

#include <gtest/gtest.h>

#include "core/hand/kinematics.h"

namespace handgraft::hand {
namespace {

Joint joint(const std::string& name,
            JointType type,
            const Eigen::Vector3d& axis_J,
            const std::string& parent,
            const std::string& child) {
  Joint result;
  result.name = name;
  result.type = type;
  result.axis_J = axis_J;
  result.parent_link = parent;
  result.child_link = child;
  result.X_PJ.translation() << 0.01, -0.02, 0.03;
  return result;
}

/// world - x - y - z - rx - ry - palm - finger, the palm with a surface.
struct Chain {
  std::vector<Link> links;
  std::vector<Joint> joints;

  Chain() {
    using Eigen::Vector3d;
    for (const char* name : {"world", "x", "y", "z", "rx", "ry", "palm", "finger"})
      links.push_back({name, {}, {}});
    links[6].visuals.push_back({geometry::makeBox({0.1, 0.1, 0.02}), "box"});
    joints = {joint("jx", JointType::kPrismatic, Vector3d::UnitX(), "world", "x"),
              joint("jy", JointType::kPrismatic, Vector3d::UnitY(), "x", "y"),
              joint("jz", JointType::kPrismatic, Vector3d::UnitZ(), "y", "z"),
              joint("jrx", JointType::kRevolute, Vector3d::UnitX(), "z", "rx"),
              joint("jry", JointType::kRevolute, Vector3d::UnitY(), "rx", "ry"),
              joint("jrz", JointType::kRevolute, Vector3d::UnitZ(), "ry", "palm"),
              joint("knuckle", JointType::kRevolute, Vector3d::UnitX(), "palm", "finger")};
  }

  [[nodiscard]] HandModel model() const { return {"hand", links, joints}; }
};

TEST(FloatingBase, IsCutOffAndStillPlacesTheHand) {
  const HandModel whole = Chain().model();
  const RootedHand rooted = cutFloatingBase(whole, {"palm"});
  ASSERT_TRUE(rooted.carrier.has_value());
  EXPECT_EQ(rooted.hand.dofNames(), std::vector<std::string>{"knuckle"});
  EXPECT_EQ(rooted.hand.links()[0].name, "palm");
  EXPECT_EQ(rooted.hand.links()[0].visuals.size(), 1U);
  EXPECT_EQ(rooted.carrier->dofNames(),
            (std::vector<std::string>{"jx", "jy", "jz", "jrx", "jry", "jrz"}));

  Eigen::VectorXd q(7);
  q << 0.1, -0.2, 0.3, 0.4, -0.5, 0.6, 0.7;
  const LinkPoses X_WL = forwardKinematics(whole, {Pose::Identity(), q});
  const Pose X_WH = carriedPose(*rooted.carrier, q.head(6));
  const LinkPoses cut_X_WL = forwardKinematics(rooted.hand, {X_WH, q.tail(1)});
  EXPECT_TRUE(cut_X_WL[0].isApprox(X_WL[6], 1e-14));
  EXPECT_TRUE(cut_X_WL[1].isApprox(X_WL[7], 1e-14));
}

TEST(FloatingBase, StaysWhereALinkOnTheWayHasASurface) {
  EXPECT_FALSE(cutFloatingBase(Chain().model(), {"ry", "palm"}).carrier.has_value());
}

TEST(FloatingBase, StaysWhereAFreedomIsMissing) {
  Chain wrist;
  wrist.joints[2].axis_J = Eigen::Vector3d::UnitY();  // z never moves
  EXPECT_FALSE(cutFloatingBase(wrist.model(), {"palm"}).carrier.has_value());
  Chain fixed;
  fixed.joints[0].type = JointType::kFixed;
  EXPECT_FALSE(cutFloatingBase(fixed.model(), {"palm"}).carrier.has_value());
}

TEST(FloatingBase, StaysWhereAJointOfTheHandFollowsIt) {
  Chain coupled;
  coupled.joints[6].mimic = Mimic{"jrz", 1.0, 0.0};
  EXPECT_FALSE(cutFloatingBase(coupled.model(), {"palm"}).carrier.has_value());
}

TEST(FloatingBase, StaysWhereTheChainBranches) {
  Chain branched;
  branched.links.push_back({"stand", {}, {}});
  branched.joints.push_back(
      joint("post", JointType::kFixed, Eigen::Vector3d::UnitX(), "z", "stand"));
  EXPECT_FALSE(cutFloatingBase(branched.model(), {"palm", "stand"}).carrier.has_value());
}

}  // namespace
}  // namespace handgraft::hand
