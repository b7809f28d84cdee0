#include "core/hand/skin.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/hand/skin_planes.h"
#include "core/hand/skin_report.h"

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

TEST(Skin, ProjectsAPlaceOfItsOwnAsWhatIsThere) {
  const Skin skin = buildSkin(makeFinger(), {}, Progress());
  for (int f = 0; f < skin.mesh().faceCount(); f += 7) {
    const geometry::SurfacePoint place_S{f, {0.3, 0.5, 0.2}};
    const auto known = skin.project(place_S);
    const auto found =
        skin.project(positionOf(skin.mesh(), place_S), normalOf(skin.mesh(), place_S));
    ASSERT_EQ(known.has_value(), found.has_value());
    if (!known) continue;
    EXPECT_EQ(known->link, found->link);
    EXPECT_LT((known->p_L - found->p_L).norm(), 1e-12);
  }
}

TEST(SkinPlanes, SayNearlyWhatTheSkinSays) {
  const Skin skin = buildSkin(makeFinger(), {}, Progress());
  const SkinPlanes planes(skin);
  int near = 0;
  int asked = 0;
  for (int f = 0; f < skin.mesh().faceCount(); ++f) {
    const geometry::SurfacePoint middle{f, Eigen::Vector3d::Constant(1.0 / 3.0)};
    const auto exact = skin.project(middle);
    const auto plane = planes.project(middle);
    ASSERT_EQ(exact.has_value(), plane.has_value());
    if (!exact) continue;
    EXPECT_EQ(exact->link, plane->link);
    EXPECT_LT((exact->p_L - plane->p_L).norm(), 1e-12);
    EXPECT_LT((exact->n_L - plane->n_L).norm(), 1e-12);
    const geometry::SurfacePoint aside{f, {0.3, 0.5, 0.2}};
    const auto exact_aside = skin.project(aside);
    const auto plane_aside = planes.project(aside);
    if (!exact_aside) continue;
    ++asked;
    if (exact_aside->link == plane_aside->link &&
        (exact_aside->p_L - plane_aside->p_L).norm() < 2e-4)
      ++near;
  }
  EXPECT_GT(asked, 100);
  EXPECT_GT(near, 0.8 * asked);
}

TEST(Skin, TakesPlacesInTheWorldToWhereEachLinkHasItsSkin) {
  const HandModel finger = makeFinger();
  const Skin skin = buildSkin(finger, {}, Progress());
  Pose X_WH = Pose::Identity();
  X_WH.translation() << 0.1, -0.2, 0.3;
  const Eigen::VectorXd q = skin.qReference().array() + 0.3;
  const LinkPoses X_WL = forwardKinematics(finger, {X_WH, q});
  const LinkPoses X_SL = forwardKinematics(finger, {Pose::Identity(), skin.qReference()});
  const LinkPoses X_SW = skin.fromWorld(finger, {X_WH, q});
  const Eigen::Vector3d p_L(0.01, 0.02, 0.03);
  for (std::size_t link = 0; link < X_SW.size(); ++link)
    EXPECT_LT((X_SW[link] * (X_WL[link] * p_L) - X_SL[link] * p_L).norm(), 1e-12);
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

/// Two fingers of 16 mm on a palm, 2 mm apart, which no joint can spread.
HandModel makePair() {
  const auto joint_to = [](const std::string& child, double x) {
    Joint joint;
    joint.name = child + "_bend";
    joint.type = JointType::kRevolute;
    joint.parent_link = "palm";
    joint.child_link = child;
    joint.X_PJ.translation() << x, 0.0, 0.011;
    joint.lower = 0.0;
    joint.upper = 1.5;
    return joint;
  };
  return {"pair",
          {boxLink("palm", {0.06, 0.06, 0.02}, Eigen::Vector3d::Zero()),
           boxLink("left", {0.016, 0.016, 0.05}, {0.0, 0.0, 0.025}),
           boxLink("right", {0.016, 0.016, 0.05}, {0.0, 0.0, 0.025})},
          {joint_to("left", -0.009), joint_to("right", 0.009)}};
}

TEST(Skin, NeverBindsAFingerToItsNeighbour) {
  const Skin skin = buildSkin(makePair(), {}, Progress());
  ASSERT_EQ(skin.mesh().components().second, 1);
  int left = 0;
  int right = 0;
  for (int v = 0; v < skin.mesh().vertexCount(); ++v) {
    const Eigen::Vector3d p_S = skin.mesh().vertex(v);
    if (p_S.z() < 0.02 || std::abs(p_S.x()) < 0.0015) continue;
    const auto hit = skin.project(p_S, skin.mesh().vertexNormals().col(v));
    ASSERT_TRUE(hit) << p_S.transpose();
    EXPECT_EQ(hit->link, p_S.x() < 0.0 ? 1 : 2) << p_S.transpose();
    ++(p_S.x() < 0.0 ? left : right);
  }
  EXPECT_GT(left, 300);
  EXPECT_GT(right, 300);
}

TEST(Skin, GivesEachLinkOneConnectedArea) {
  const Skin skin = buildSkin(makePair(), {}, Progress());
  const std::vector<int>& links = skin.faceLinks();
  // A face that disagrees with all its neighbours would be an island.
  for (int f = 0; f < skin.mesh().faceCount(); ++f) {
    int agreeing = 0;
    for (int c = 0; c < 3; ++c) {
      const int other = geometry::TriangleMesh::faceOf(skin.mesh().twin(3 * f + c));
      if (links[static_cast<std::size_t>(other)] == links[static_cast<std::size_t>(f)])
        ++agreeing;
    }
    EXPECT_GT(agreeing, 0) << "face " << f;
  }
}

/// A palm with a square opening of 30 mm, of four bars, and nothing else.
HandModel makeFrame() {
  Link frame = boxLink("frame", {0.05, 0.01, 0.008}, {0.0, 0.02, 0.0});
  for (const Link& bar : {boxLink("", {0.05, 0.01, 0.008}, {0.0, -0.02, 0.0}),
                          boxLink("", {0.01, 0.05, 0.008}, {0.02, 0.0, 0.0}),
                          boxLink("", {0.01, 0.05, 0.008}, {-0.02, 0.0, 0.0})})
    frame.visuals.push_back(bar.visuals.front());
  return {"frame hand", {frame}, {}};
}

TEST(Skin, ShutsAnOpeningWithoutBuryingTheFrame) {
  SkinReport report;
  const Skin skin = buildSkin(makeFrame(), {}, Progress(), &report);
  measure(skin, report);
  EXPECT_TRUE(report.isValid()) << describe(report);
  EXPECT_EQ(skin.mesh().eulerCharacteristic(), 2);
  // The sheet is there before the wrap, of which there is one.
  ASSERT_EQ(report.steps.size(), 3u) << describe(report);
  EXPECT_EQ(report.steps[0].sheets, 1);
  EXPECT_EQ(report.steps[1].action, "wrap");
  EXPECT_EQ(report.steps[1].genus, 0);
  EXPECT_EQ(report.steps[2].action, "even out triangles");
  // The sheet's middle is of no link, the bars are.
  EXPECT_FALSE(skin.project({0.0, 0.0, 0.0}, Eigen::Vector3d::UnitZ()));
  EXPECT_TRUE(skin.project({0.02, 0.0, 0.0048}, Eigen::Vector3d::UnitZ()));
  ASSERT_EQ(report.notes.size(), 1u);
  EXPECT_THAT(report.notes[0], ::testing::HasSubstr("1 sheets shut through-holes"));
}

TEST(Skin, SaysPlainlyThatLinksCannotBeJoined) {
  const HandModel far_apart("far apart",
                            {{"halves",
                              {boxLink("", {0.05, 0.05, 0.05}, {0.3, 0.0, 0.0}).visuals[0],
                               boxLink("", {0.05, 0.05, 0.05}, {-0.3, 0.0, 0.0}).visuals[0]},
                              {}}},
                            {});
  SkinReport report;
  const Skin skin = buildSkin(far_apart, {}, Progress(), &report);
  measure(skin, report);
  EXPECT_EQ(report.pieces, 2);
  EXPECT_EQ(report.genus, 0);
  EXPECT_TRUE(report.is_closed);
  EXPECT_FALSE(report.isValid());
  ASSERT_EQ(report.notes.size(), 1u);
  EXPECT_THAT(report.notes[0], ::testing::HasSubstr("2 separate pieces"));
  EXPECT_EQ(report.steps.front().alpha_m, 0.003);
  EXPECT_THAT(report.steps.front().verdict, ::testing::StartsWith("kept"));
}

TEST(Skin, WrapsTheCollisionShapesWhereAsked) {
  Link link = boxLink("palm", {0.06, 0.06, 0.02}, Eigen::Vector3d::Zero());
  link.collisions = boxLink("", {0.03, 0.03, 0.03}, Eigen::Vector3d::Zero()).visuals;
  const HandModel model("one link", {link}, {});
  SkinOptions options;
  const double visual =
      buildSkin(model, options, Progress()).mesh().vertices().row(0).maxCoeff();
  options.source = SurfaceSource::kCollisions;
  const Skin skin = buildSkin(model, options, Progress());
  EXPECT_NEAR(visual, 0.0308, 1e-4);
  EXPECT_NEAR(skin.mesh().vertices().row(0).maxCoeff(), 0.0158, 1e-4);
  EXPECT_TRUE(skin.project({0.0158, 0.0, 0.0}, Eigen::Vector3d::UnitX()));
}

TEST(SkinReport, MeasuresABallAroundABall) {
  const HandModel model("ball", {{"ball", {{geometry::makeSphere(0.02, 5), "sphere"}}, {}}},
                        {});
  const Skin skin(model, geometry::makeSphere(0.021, 5), Eigen::VectorXd(0), 0.004);
  SkinReport report;
  measure(skin, report);
  EXPECT_TRUE(report.isValid());
  EXPECT_EQ(report.vertices, 10242);
  EXPECT_NEAR(report.mean_clearance_m, 0.001, 1e-5);
  EXPECT_NEAR(report.max_clearance_m, 0.001, 1e-5);
  EXPECT_EQ(report.projected_share, 1.0);
  EXPECT_GT(report.smallest_angle_rad, 0.85);
  EXPECT_LT(report.shortest_edge_m, report.mean_edge_m);
  EXPECT_LT(report.mean_edge_m, report.longest_edge_m);
}

TEST(SkinReferencePose, StaysWithinTheLimitsAndStraight) {
  const HandModel model = makeFinger();
  const Eigen::VectorXd q = skinReferencePose(model);
  EXPECT_EQ(q[0], 0.0);
}

}  // namespace
}  // namespace handgraft::hand
