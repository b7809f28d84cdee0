#include "core/hand/skin.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"

namespace handgraft::hand {
namespace {

Link boxLink(const std::string& name,
             const Eigen::Vector3d& size,
             const Eigen::Vector3d& centre) {
  Eigen::Affine3d X = Eigen::Affine3d::Identity();
  X.translation() = centre;
  return {name, {{geometry::transformed(geometry::makeBox(size), X), "box"}}, {}};
}

/// A palm and a finger that stands up from it, 1 mm apart.
HandModel makeFinger() {
  Joint joint;
  joint.name = "bend";
  joint.type = JointType::kRevolute;
  joint.parent_link = "palm";
  joint.child_link = "finger";
  joint.X_PJ.translation() << 0.0, 0.0, 0.011;
  joint.axis_J = Eigen::Vector3d::UnitY();
  joint.lower = 0.0;
  joint.upper = 1.5;
  return {"finger hand",
          {boxLink("palm", {0.06, 0.06, 0.02}, Eigen::Vector3d::Zero()),
           boxLink("finger", {0.016, 0.016, 0.05}, {0.0, 0.0, 0.025})},
          {joint}};
}

TEST(Skin, IsClosedAndOfOnePiece) {
  const Skin skin = buildSkin(makeFinger(), {}, Progress());
  EXPECT_TRUE(skin.mesh().isClosed());
  EXPECT_EQ(skin.mesh().components().second, 1);
  EXPECT_EQ(skin.mesh().eulerCharacteristic(), 2);
}

TEST(Skin, IsTheSameEveryTime) {
  const Skin a = buildSkin(makeFinger(), {}, Progress());
  const Skin b = buildSkin(makeFinger(), {}, Progress());
  EXPECT_EQ(a.mesh().vertices(), b.mesh().vertices());
  EXPECT_EQ(a.mesh().faces(), b.mesh().faces());
}

TEST(Skin, ProjectsOntoTheLinkItCovers) {
  const Skin skin = buildSkin(makeFinger(), {}, Progress());
  const auto hit = skin.project({0.009, 0.0, 0.036}, Eigen::Vector3d::UnitX());
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->link, 1);
  EXPECT_TRUE(hit->p_L.isApprox(Eigen::Vector3d(0.008, 0.0, 0.025), 1e-12));
  EXPECT_TRUE(hit->n_L.isApprox(Eigen::Vector3d::UnitX(), 1e-12));
  EXPECT_NEAR(hit->distance_m, 0.001, 1e-12);
}

TEST(Skin, TurnsTheNormalOfATurnedFace) {
  const Skin skin = buildSkin(makeFinger(), {}, Progress());
  const auto hit = skin.project({0.009, 0.0, 0.036}, -Eigen::Vector3d::UnitX());
  ASSERT_TRUE(hit);
  EXPECT_TRUE(hit->n_L.isApprox(-Eigen::Vector3d::UnitX(), 1e-12));
}

TEST(Skin, ProjectsNothingBeyondEpsilon) {
  const Skin skin = buildSkin(makeFinger(), {}, Progress());
  EXPECT_FALSE(skin.project({0.05, 0.0, 0.06}, Eigen::Vector3d::UnitX()));
  EXPECT_FALSE(skin.project({std::nan(""), 0.0, 0.0}, Eigen::Vector3d::UnitX()));
}

TEST(Skin, RefusesAHandWithoutASurfaceOrInOtherUnits) {
  EXPECT_THROW((void)buildSkin(HandModel("bare", {{"palm", {}, {}}}, {}), {}, Progress()),
               InvalidInput);
  const HandModel giant("giant", {boxLink("palm", {60.0, 60.0, 20.0}, Eigen::Vector3d::Zero())},
                        {});
  EXPECT_THROW((void)buildSkin(giant, {}, Progress()), InvalidInput);
  SkinOptions options;
  options.alpha_m = 0.0;
  EXPECT_THROW((void)buildSkin(makeFinger(), options, Progress()), InvalidInput);
}

TEST(Skin, StopsOnWish) {
  Progress progress;
  progress.cancel();
  EXPECT_THROW((void)buildSkin(makeFinger(), {}, progress), Cancelled);
}

TEST(SkinReferencePose, StaysWithinTheLimitsAndStraight) {
  const HandModel model = makeFinger();
  const Eigen::VectorXd q = skinReferencePose(model);
  EXPECT_EQ(q[0], 0.0);
}

}  // namespace
}  // namespace handgraft::hand
