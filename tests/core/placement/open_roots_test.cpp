#include "core/placement/open_roots.h"

#include <gtest/gtest.h>

#include "tests/core/session/ball_grasp.h"
#include "tests/core/session/two_plates.h"
#include "tests/support/plate_hand.h"
#include "tests/support/plates.h"

namespace handgraft::placement {
namespace {

using test::TwoPlates;

TEST(RootShownBy, IsThePlaceOfThePlateThatThePointStandsOver) {
  const geometry::TriangleMesh plate = test::makePlate(100, 100, 0.001);
  const auto model = test::makeRigidHand(plate);
  const hand::Skin skin = test::makeRigidSkin(*model, plate);
  hand::HandPose pose{Pose::Identity(), Eigen::VectorXd(0)};
  pose.X_WH.linear() = rotationFromVector({0.4, -0.7, 0.2});
  pose.X_WH.translation() << 0.3, 0.2, -0.1;
  const Eigen::Vector3d p_W = pose.X_WH * Eigen::Vector3d(0.0123, 0.004, 0.02);
  const Eigen::Vector3d up_W = pose.X_WH.linear() * Eigen::Vector3d::UnitZ();

  const hand::LinkPoses X_SW = skin.fromWorld(*model, pose);
  const auto root = rootShownBy(SkinFaces(skin), X_SW, {1}, p_W, -up_W);
  ASSERT_TRUE(root.has_value());
  EXPECT_LT((positionOf(plate, *root) - Eigen::Vector3d(0.0123, 0.004, 0.0)).norm(), 0.001);
  // Nothing looks at what turns its back, and links that are not permitted show nothing.
  EXPECT_FALSE(rootShownBy(SkinFaces(skin), X_SW, {1}, p_W, up_W).has_value());
  EXPECT_FALSE(rootShownBy(SkinFaces(skin), X_SW, {0}, p_W, -up_W).has_value());
}

TEST(RootShownBy, FollowsTheJoints) {
  const test::SmallHand small = test::makeSmallHand();
  hand::HandPose pose{Pose::Identity(), Eigen::VectorXd::Constant(6, 0.4)};
  const hand::ContactSite& site = small.sites[1];
  const int link = small.model->linkIndex(site.link);
  std::vector<char> permitted(static_cast<std::size_t>(small.model->linkCount()), 0);
  permitted[static_cast<std::size_t>(link)] = 1;
  const Pose X_WL = forwardKinematics(*small.model, pose)[static_cast<std::size_t>(link)];
  const auto root =
      rootShownBy(SkinFaces(*small.skin), small.skin->fromWorld(*small.model, pose), permitted,
                  X_WL * (site.p_L + 0.005 * site.n_L), -(X_WL.linear() * site.n_L));
  ASSERT_TRUE(root.has_value());
  const geometry::SurfacePoint expected = small.skin->skinPointOf(link, site.p_L);
  EXPECT_LT(
      (positionOf(small.skin->mesh(), *root) - positionOf(small.skin->mesh(), expected)).norm(),
      0.002);
}

TEST(Session, SlidesRootsOfFoundSitesToWhereTheyFit) {
  for (const bool avoids : {false, true}) {
    session::Session session = TwoPlates().open();
    session::SolverSettings solving;
    solving.avoid_penetration = avoids;
    const session::Solution solution = session.solve(solving, {}, Progress());
    for (const session::SessionPatch& patch : solution.patches)
      EXPECT_FALSE(patch.transferred.is_draft);
    for (const optimize::PatchFit& fit : solution.report.patches) {
      EXPECT_EQ(fit.point_count, 25);
      // Roots lie in the middle of faces of 2 mm; 0.4 mm more are kept free.
      EXPECT_LT(fit.mean_mm, avoids ? 1.5 : 1.0);
    }
  }
}

TEST(Session, LeavesRootsOnSitesThatSomebodyChose) {
  TwoPlates plates;
  plates.hand.sites_are_found = false;
  session::Session session = plates.open();
  for (const optimize::PatchFit& fit : session.optimize({}, Progress()).patches)
    EXPECT_NEAR(fit.mean_mm, 5.0, 0.5);
}

TEST(Session, LeavesRootsWhereTheUserPutsThem) {
  session::Session session = TwoPlates().open();
  const geometry::SurfacePoint thumb = session.patches()[0].placement->root_S;
  const geometry::SurfacePoint index = session.patches()[1].placement->root_S;
  session.apply(session::PatchRootEdit{"thumb", session::Side::kHand, thumb});
  session.apply(session::PatchDirectionEdit{"index", session::Side::kHand, 0.1});
  session.optimize({}, Progress());
  EXPECT_EQ(session.patches()[0].placement->root_S.face, thumb.face);
  EXPECT_EQ(session.patches()[1].placement->root_S.face, index.face);
}

}  // namespace
}  // namespace handgraft::placement
