#include "core/hand/variant.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/hand/kinematics.h"
#include "core/hand/skin_bending.h"

#include "tests/support/small_hand.h"

namespace handgraft::hand {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

/// The small hand, its frames turned, its last joint a slider, which thumb_2 and a second
/// slider follow.
HandModel coupledHand() {
  const HandModel small = *test::makeSmallHand().model;
  std::vector<Joint> joints = small.joints();
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const double t = 0.3 + 0.1 * static_cast<double>(i);
    joints[i].X_PJ.linear() = rotationFromVector(Eigen::Vector3d(t, -0.2, 0.5 * t));
    joints[i].axis_J = Eigen::Vector3d(1.0, t, -0.4).normalized();
  }
  joints[5].type = JointType::kPrismatic;  // middle_2
  joints[5].lower = 0.0;
  joints[5].upper = 0.02;
  joints[1].mimic = Mimic{"middle_2", 30.0, 0.1};  // thumb_2, in rad
  joints[3].type = JointType::kPrismatic;          // index_2
  joints[3].mimic = Mimic{"middle_2", 0.5, 0.001};
  joints[3].lower = -1.0;
  const HandModel coupled("coupled", small.links(), joints);
  return coupled.withRestPose(coupled.restPose().cwiseMax(0.01).cwiseMin(coupled.upper()));
}

Eigen::VectorXd somePose(const HandModel& model) {
  Eigen::VectorXd q(model.dofCount());
  for (int i = 0; i < q.size(); ++i)
    q[i] = model.lower()[i] + (0.2 + 0.13 * i) * (model.upper()[i] - model.lower()[i]);
  return q;
}

std::string faultOf(const HandModel& model, const std::vector<HandChange>& changes) {
  try {
    (void)makeVariant(model, "variant", changes);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "no fault";
}

void expectSameBytes(const HandModel& a, const HandModel& b) {
  ASSERT_EQ(a.linkCount(), b.linkCount());
  EXPECT_EQ(a.lower(), b.lower());
  EXPECT_EQ(a.upper(), b.upper());
  EXPECT_EQ(a.restPose(), b.restPose());
  for (std::size_t i = 0; i < a.joints().size(); ++i) {
    EXPECT_EQ(a.joints()[i].name, b.joints()[i].name);
    EXPECT_EQ(a.joints()[i].X_PJ.matrix(), b.joints()[i].X_PJ.matrix());
    EXPECT_EQ(a.joints()[i].axis_J, b.joints()[i].axis_J);
  }
  for (std::size_t i = 0; i < a.links().size(); ++i) {
    EXPECT_EQ(a.links()[i].name, b.links()[i].name);
    for (std::size_t s = 0; s < a.links()[i].visuals.size(); ++s)
      EXPECT_EQ(a.links()[i].visuals[s].mesh_L.vertices(),
                b.links()[i].visuals[s].mesh_L.vertices());
  }
}

TEST(Variant, IsTheSameHandWithoutAChange) {
  const HandModel hand = coupledHand();
  expectSameBytes(makeVariant(hand, "coupled", {}).model, hand);
  const HandVariant same = makeVariant(hand, "coupled",
                                       {{HandProperty::kLength, "index_lower", 1.0},
                                        {HandProperty::kSize, "", 1.0},
                                        {HandProperty::kSize, "palm", 1.0},
                                        {HandProperty::kRange, "thumb_1", 1.0},
                                        {HandProperty::kLower, "thumb_1", -0.5},
                                        {HandProperty::kUpper, "thumb_1", 1.5}});
  expectSameBytes(same.model, hand);
  EXPECT_FALSE(same.shape_changed);
}

TEST(Variant, OfAnotherSizeMovesAsTheScaledHand) {
  const HandModel hand = coupledHand();
  for (const double factor : {0.4, 1.7}) {
    const HandVariant variant = makeVariant(hand, "big", {{HandProperty::kSize, "", factor}});
    const Eigen::VectorXd q = somePose(hand);
    const Eigen::VectorXd q_variant = poseOfVariant(variant, q);
    EXPECT_NEAR(q_variant[3], factor * q[3], 1e-15) << "the slider";
    EXPECT_TRUE(variant.model.restPose().isApprox(poseOfVariant(variant, hand.restPose())));
    const LinkPoses X = forwardKinematics(hand, {Pose::Identity(), q});
    const LinkPoses pose_of_variant =
        forwardKinematics(variant.model, {Pose::Identity(), q_variant});
    for (std::size_t link = 0; link < X.size(); ++link) {
      EXPECT_TRUE(pose_of_variant[link].linear().isApprox(X[link].linear(), 1e-12));
      EXPECT_LT((pose_of_variant[link].translation() - factor * X[link].translation()).norm(),
                1e-15);
      EXPECT_LT((variant.model.links()[link].visuals[0].mesh_L.vertices() -
                 factor * hand.links()[link].visuals[0].mesh_L.vertices())
                    .cwiseAbs()
                    .maxCoeff(),
                1e-15);
    }
  }
}

/// A jaw whose box lies beside its slide: 12 mm thick, its gripping face in the plane y = 0.
HandModel jawBy(JointType type, const Eigen::Vector3d& axis, double x = 0.0) {
  Link palm{"palm", {}, {}};
  palm.visuals.push_back({geometry::makeBox({0.06, 0.12, 0.05}), "box"});
  Link finger{"finger", {}, {}};
  finger.visuals.push_back(
      {geometry::transformed(geometry::makeBox({0.022, 0.012, 0.07}),
                             Eigen::Affine3d(Eigen::Translation3d(x, 0.006, 0.035))),
       "box"});
  Joint joint;
  joint.name = "joint";
  joint.type = type;
  joint.parent_link = "palm";
  joint.child_link = "finger";
  joint.axis_J = axis;
  joint.lower = 0.0;
  joint.upper = 0.05;
  return HandModel("jaw", {palm, finger}, {joint});
}

/// How far a finger twice as long reaches beyond the one as it is, by axis.
Eigen::Vector3d grownBy(const HandModel& model) {
  const HandVariant variant =
      makeVariant(model, "long", {{HandProperty::kLength, "finger", 2.0}});
  const auto extent = [](const HandModel& one) {
    const auto& vertices = one.links()[1].visuals[0].mesh_L.vertices();
    return Eigen::Vector3d(vertices.rowwise().maxCoeff() - vertices.rowwise().minCoeff());
  };
  return extent(variant.model) - extent(model);
}

// A jaw slides across itself: its faces stay where they are, and parallel.
TEST(Variant, ALongerJawStaysStraight) {
  const HandModel jaw = jawBy(JointType::kPrismatic, Eigen::Vector3d::UnitY());
  EXPECT_TRUE(grownBy(jaw).isApprox(Eigen::Vector3d(0, 0, 0.07), 1e-12));
  const HandVariant variant =
      makeVariant(jaw, "long", {{HandProperty::kLength, "finger", 1.2}});
  const auto& vertices = variant.model.links()[1].visuals[0].mesh_L.vertices();
  EXPECT_NEAR(vertices.row(1).minCoeff(), 0.0, 1e-15) << "its gripping face";
  EXPECT_NEAR(vertices.row(1).maxCoeff(), 0.012, 1e-15);
}

// What lies beside it along the axis that it bends about is width, no length.
TEST(Variant, ALongerFingertipGrowsAcrossTheAxisThatItBendsAbout) {
  const HandModel tip = jawBy(JointType::kRevolute, Eigen::Vector3d::UnitX(), 0.02);
  EXPECT_NEAR(grownBy(tip).x(), 0.0, 1e-15);
  const HandModel turning = jawBy(JointType::kRevolute, Eigen::Vector3d::UnitZ());
  EXPECT_GT(grownBy(turning).z(), 0.06) << "one that turns about itself grows along that";
  const HandModel telescope = jawBy(JointType::kPrismatic, Eigen::Vector3d::UnitZ());
  EXPECT_GT(grownBy(telescope).z(), 0.06);
}

TEST(Variant, ALongerLinkMovesItsNextJointsAlongAndStretchesBetween) {
  const auto small = test::makeSmallHand();
  const HandVariant variant =
      makeVariant(*small.model, "long", {{HandProperty::kLength, "index_lower", 1.5}});
  EXPECT_TRUE(variant.shape_changed);
  for (const Joint& joint : variant.model.joints()) {
    const double z = joint.name == "index_2"    ? 1.5 * 0.035
                     : joint.name.back() == '2' ? 0.035
                                                : 0.005;
    EXPECT_NEAR(joint.X_PJ.translation().z(), z, 1e-15) << joint.name;
  }
  const int link = small.model->linkIndex("index_lower");
  const auto& before = small.model->links()[link].visuals[0].mesh_L.vertices();
  const auto& after = variant.model.links()[link].visuals[0].mesh_L.vertices();
  EXPECT_LT((after.topRows(2) - before.topRows(2)).cwiseAbs().maxCoeff(), 1e-15) << "width";
  EXPECT_LT((after.row(2) - 1.5 * before.row(2)).cwiseAbs().maxCoeff(), 1e-15) << "length";
}

TEST(Variant, AFingertipGetsLongerTowardsItsMiddle) {
  const auto small = test::makeSmallHand();
  const HandVariant variant =
      makeVariant(*small.model, "long", {{HandProperty::kLength, "index_tip", 2.0}});
  const int link = small.model->linkIndex("index_tip");
  EXPECT_TRUE(variant.stretch_L[link].isApprox(
      Eigen::Vector3d(1.0, 1.0, 2.0).asDiagonal().toDenseMatrix(), 1e-9));
}

TEST(Variant, TakesItsSitesAlong) {
  const auto small = test::makeSmallHand();
  const HandVariant variant = makeVariant(
      *small.model, "odd",
      {{HandProperty::kLength, "thumb_tip", 1.3}, {HandProperty::kSize, "index_tip", 0.7}});
  const std::vector<ContactSite> sites = sitesOfVariant(variant, small.sites);
  validate(variant.model, sites);
  EXPECT_LT((sites[0].p_L - Eigen::Vector3d(small.sites[0].p_L.x(), 0, 0.02 * 1.3)).norm(),
            1e-9);
  EXPECT_LT((sites[1].p_L - 0.7 * small.sites[1].p_L).norm(), 1e-15);
  EXPECT_EQ(sites[2].p_L, small.sites[2].p_L);
}

TEST(Variant, LimitsHoldForWhatFollows) {
  const HandModel hand = coupledHand();
  const HandVariant variant =
      makeVariant(hand, "wide", {{HandProperty::kUpper, "middle_2", 0.3}});
  EXPECT_DOUBLE_EQ(variant.model.upper()[3], 0.3);
  EXPECT_EQ(variant.model.lower()[3], hand.lower()[3]);
  // Of another size first: the limit asked for is the variant's own.
  const HandVariant scaled = makeVariant(
      hand, "wide", {{HandProperty::kSize, "", 2.0}, {HandProperty::kUpper, "middle_2", 0.3}});
  EXPECT_DOUBLE_EQ(scaled.model.upper()[3], 0.3);
}

TEST(Variant, TheRestPoseStaysWithinTheLimits) {
  const HandModel hand = coupledHand();
  const HandVariant variant =
      makeVariant(hand, "bent", {{HandProperty::kLower, "thumb_1", 0.25}});
  EXPECT_EQ(variant.model.lower()[0], 0.25);
  EXPECT_EQ(variant.model.restPose()[0], 0.25);
}

TEST(Variant, ARangeGrowsAboutRest) {
  const auto small = test::makeSmallHand();
  const HandModel hand =
      small.model->withRestPose(Eigen::VectorXd::Constant(small.model->dofCount(), 0.5));
  const HandVariant variant =
      makeVariant(hand, "wide", {{HandProperty::kRange, "index_1", 0.5}});
  EXPECT_DOUBLE_EQ(variant.model.lower()[2], 0.0);
  EXPECT_DOUBLE_EQ(variant.model.upper()[2], 1.0);
}

TEST(Variant, NamesWhatIsWrong) {
  const HandModel hand = coupledHand();
  EXPECT_THAT(faultOf(hand, {{HandProperty::kUpper, "elbow", 1.0}}),
              AllOf(HasSubstr("'elbow'"), HasSubstr("'thumb_1'")));
  EXPECT_THAT(faultOf(hand, {{HandProperty::kUpper, "thumb_2", 1.0}}),
              HasSubstr("follows joint 'middle_2'"));
  EXPECT_THAT(faultOf(hand, {{HandProperty::kLower, "thumb_1", 1.7}}),
              AllOf(HasSubstr("'thumb_1'"), HasSubstr("1.7"), HasSubstr("1.5")));
  EXPECT_THAT(faultOf(hand, {{HandProperty::kUpper, "thumb_1", 1e4}}),
              AllOf(HasSubstr("10000"), HasSubstr("-1000 to 1000")));
  EXPECT_THAT(faultOf(hand, {{HandProperty::kUpper, "thumb_1", std::nan("")}}),
              HasSubstr("'thumb_1'"));
  EXPECT_THAT(faultOf(hand, {{HandProperty::kSize, "", 11.0}}),
              AllOf(HasSubstr("hand"), HasSubstr("0.1 to 10")));
  EXPECT_THAT(faultOf(hand, {{HandProperty::kLength, "nail", 1.1}}),
              AllOf(HasSubstr("'nail'"), HasSubstr("'palm'")));
  EXPECT_THAT(faultOf(hand, {{HandProperty::kLength, "", 1.1}}), HasSubstr("no link ''"));
  std::vector<Joint> joints = test::makeSmallHand().model->joints();
  joints[0].upper = std::numeric_limits<double>::infinity();
  EXPECT_THAT(faultOf({"endless", test::makeSmallHand().model->links(), joints},
                      {{HandProperty::kRange, "thumb_1", 2.0}}),
              HasSubstr("no limits"));
}

TEST(Variant, ALinkWithoutLengthIsNamedBesideThoseThatHaveOne) {
  const auto small = test::makeSmallHand();
  std::vector<Link> links = small.model->links();
  std::vector<Joint> joints = small.model->joints();
  links.push_back({"pivot", {}, {}});
  Joint joint = joints[0];
  joint.name = "pivot_1";
  joint.child_link = "pivot";
  joints.push_back(joint);
  EXPECT_THAT(faultOf({"pivoted", links, joints}, {{HandProperty::kLength, "pivot", 1.1}}),
              AllOf(HasSubstr("'pivot' has no length"), HasSubstr("'thumb_lower'")));
}

// === The skin

double farthestFromLinks(const Skin& skin) {
  double most = 0.0;
  for (int v = 0; v < skin.mesh().vertexCount(); ++v)
    most = std::max(most, skin.links().nearest(skin.mesh().vertex(v), 1.0)->distance_m);
  return most;
}

TEST(SkinBending, KeepsTheSkinOfAHandOfTheSameShape) {
  const auto small = test::makeSmallHand();
  const SkinBending bending(small.model, small.skin);
  const HandVariant tight =
      makeVariant(*small.model, "tight", {{HandProperty::kUpper, "thumb_1", 0.3}});
  EXPECT_EQ(bending.bent(tight), small.skin);
}

TEST(SkinBending, OfAHandOfAnotherSizeIsTheScaledSkin) {
  const auto small = test::makeSmallHand();
  const SkinBending bending(small.model, small.skin);
  const HandVariant variant =
      makeVariant(*small.model, "big", {{HandProperty::kSize, "", 1.7}});
  const auto skin = bending.bent(variant);
  EXPECT_LT(
      (skin->mesh().vertices() - 1.7 * small.skin->mesh().vertices()).cwiseAbs().maxCoeff(),
      1e-8);
  EXPECT_DOUBLE_EQ(skin->epsilon(), 1.7 * small.skin->epsilon());
  EXPECT_EQ(skin->faceLinks(), small.skin->faceLinks());
}

TEST(SkinBending, StaysOnTheLinksThatGotLonger) {
  // The small hand's skin is its links' surfaces, one by one: bending must be exact on them.
  const auto small = test::makeSmallHand();
  ASSERT_LT(farthestFromLinks(*small.skin), 1e-12);
  const SkinBending bending(small.model, small.skin);
  const HandVariant variant = makeVariant(
      *small.model, "long",
      {{HandProperty::kLength, "index_lower", 1.4}, {HandProperty::kSize, "thumb_tip", 1.2}});
  const auto skin = bending.bent(variant);
  EXPECT_LT(farthestFromLinks(*skin), 1e-8);
  const LinkPoses X_SL =
      forwardKinematics(variant.model, {Pose::Identity(), skin->qReference()});
  const auto tip =
      skin->project(X_SL[variant.model.linkIndex("index_tip")] * Eigen::Vector3d(0, 0, 0.03),
                    Eigen::Vector3d::UnitZ());
  ASSERT_TRUE(tip.has_value());
  EXPECT_EQ(tip->link, variant.model.linkIndex("index_tip"));
}

}  // namespace
}  // namespace handgraft::hand
