// Variants of built-in and real hands: kinematics against DART, skins by what a skin promises.
#include <random>

#include <gtest/gtest.h>

#include "core/hand/kinematics.h"
#include "core/hand/skin_bending.h"
#include "core/hand/skin_cache.h"
#include "core/io/urdf_file.h"
#include "core/io/urdf_writer.h"

#include "tests/support/dart_hand.h"
#include "tests/support/shared_data.h"

namespace handgraft::hand {
namespace {

std::filesystem::path builtInHand(const std::string& name) {
  return test::sourceDirectory() / "server/models/hands" / name / (name + ".urdf");
}

/// The largest difference of a link's pose over some random joints.
double differenceFrom(const dart::dynamics::SkeletonPtr& skeleton, const HandModel& model) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  double worst = 0.0;
  for (int trial = 0; trial < 20; ++trial) {
    Eigen::VectorXd q(model.dofCount());
    for (int i = 0; i < model.dofCount(); ++i) {
      q[i] = uniform(random);
      skeleton->getDof(model.dofJoint(i).name)->setPosition(q[i]);
    }
    const LinkPoses X_HL = forwardKinematics(model, {Pose::Identity(), q});
    for (int link = 0; link < model.linkCount(); ++link) {
      const auto* body = skeleton->getBodyNode(model.links()[link].name);
      worst = std::max(
          worst,
          (body->getWorldTransform().matrix() - X_HL[link].matrix()).cwiseAbs().maxCoeff());
    }
  }
  return worst;
}

TEST(RealVariants, MoveAsDartMovesAHandWithThatLength) {
  const auto path = builtInHand("human20");
  const HandModel hand = io::readUrdfKinematics(path);
  const auto skeleton = test::dartHand(path);
  ASSERT_NE(skeleton, nullptr);
  // DART is told of the length in its own terms: the next joint's place on the parent body.
  const int link = hand.linkIndex("index_proximal");
  for (const HandModel::Node& node : hand.nodes()) {
    if (node.parent_link != link) continue;
    auto* joint = skeleton->getJoint(node.joint_name);
    Eigen::Isometry3d T = joint->getTransformFromParentBodyNode();
    ASSERT_GT(T.translation().norm(), 0.01);
    T.translation() *= 1.35;
    joint->setTransformFromParentBodyNode(T);
  }
  EXPECT_GT(differenceFrom(skeleton, hand), 0.005) << "the check would see the change";
  const HandVariant variant =
      makeVariant(hand, "long", {{HandProperty::kLength, "index_proximal", 1.35}});
  EXPECT_LT(differenceFrom(skeleton, variant.model), 1e-9);
}

TEST(RealVariants, TheirUrdfIsTheVariant) {
  const HandModel hand = io::readUrdfKinematics(builtInHand("human20"));
  const HandVariant variant = makeVariant(
      hand, "odd",
      {{HandProperty::kSize, "", 0.8}, {HandProperty::kLength, "thumb_proximal", 1.2}});
  const auto path = test::scratchDirectory() / "variant.urdf";
  std::ofstream(path) << io::kinematicUrdfText(variant.model, "written by a test");
  const auto skeleton = test::dartHand(path);
  ASSERT_NE(skeleton, nullptr);
  EXPECT_LT(differenceFrom(skeleton, variant.model), 1e-9);
}

struct BentSkin {
  SkinReport before;
  SkinReport after;
};

BentSkin bend(const std::filesystem::path& urdf, const std::vector<HandChange>& changes) {
  const auto model = std::make_shared<const HandModel>(io::readUrdf(urdf).model);
  const auto skin = std::make_shared<const Skin>(
      SkinCache::fromEnvironment().get(*model, SkinOptions(), Progress()));
  const SkinBending bending(model, skin);
  BentSkin result;
  measure(*skin, result.before);
  measure(*bending.bent(makeVariant(*model, "variant", changes)), result.after);
  return result;
}

void expectSound(const BentSkin& bent) {
  EXPECT_TRUE(bent.after.isValid()) << describe(bent.after);
  EXPECT_LT(bent.after.mean_clearance_m, 1.2 * bent.before.mean_clearance_m);
  EXPECT_GT(bent.after.projected_share, bent.before.projected_share - 0.005);
  EXPECT_NE(bent.after.longest_edge_m, bent.before.longest_edge_m) << "nothing was bent";
}

TEST(RealVariants, ALongerFingerKeepsASoundSkin) {
  expectSound(bend(builtInHand("human20"), {{HandProperty::kLength, "index_proximal", 1.3},
                                            {HandProperty::kLength, "index_middle", 1.3},
                                            {HandProperty::kLength, "index_distal", 1.2}}));
}

TEST(RealVariants, AShorterThumbKeepsASoundSkin) {
  expectSound(bend(builtInHand("tendon16"), {{HandProperty::kLength, "thumb_proximal", 0.7},
                                             {HandProperty::kLength, "thumb_middle", 0.8}}));
}

TEST(RealVariants, ABroaderPalmKeepsASoundSkin) {
  expectSound(bend(builtInHand("human20"), {{HandProperty::kSize, "palm", 1.2}}));
}

TEST(RealVariants, ARealAllegroWithLongFingersKeepsASoundSkin) {
  HANDGRAFT_NEEDS_SHARED_DATA("hands/allegro_right/allegro_hand_right.urdf");
  expectSound(bend(test::sharedData("hands/allegro_right/allegro_hand_right.urdf"),
                   {{HandProperty::kLength, "link_1.0", 1.25},
                    {HandProperty::kLength, "link_2.0", 1.25},
                    {HandProperty::kSize, "link_15.0", 1.1}}));
}

}  // namespace
}  // namespace handgraft::hand
