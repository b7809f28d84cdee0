#include "core/hand/hand_solid.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/geometry/sample_thinning.h"
#include "core/hand/kinematics.h"

#include "tests/core/hand/palm_of_parts.h"
#include "tests/support/ball_hand.h"

namespace handgraft::hand {
namespace {

using Eigen::Vector3d;

constexpr double kRadius = 0.01;
constexpr double kBallArea = 4.0 * std::numbers::pi * kRadius * kRadius;

/// Four links in a row along x, hinged about z, 30 mm apart.
test::BallHand chainOfBalls() {
  std::vector<Link> links(4);
  std::vector<Joint> joints;
  for (std::size_t i = 0; i < links.size(); ++i) {
    links[i].name = "link" + std::to_string(i);
    if (i == 0) continue;
    Joint joint;
    joint.name = "joint" + std::to_string(i);
    joint.type = JointType::kRevolute;
    joint.parent_link = links[i - 1].name;
    joint.child_link = links[i].name;
    joint.X_PJ.translation() = Vector3d(0.03, 0, 0);
    joint.axis_J = Vector3d::UnitZ();
    joint.lower = -3.0;
    joint.upper = 3.0;
    joints.push_back(joint);
  }
  return test::withBalls(HandModel("chain", links, joints), kRadius);
}

/// The balls' skin over links of other meshes.
Skin skinOf(const test::BallHand& balls, const HandModel& model) {
  return {model, balls.skin->mesh(), model.restPose(), 0.004};
}

/// On all sides alike; `tolerance` of the area.
void expectSpreadOverBall(const SampleSet& set, double tolerance) {
  double area = 0.0;
  Vector3d middle = Vector3d::Zero();
  for (const SurfaceSample& sample : set.samples) {
    EXPECT_NEAR(sample.p_L.norm(), kRadius, 1e-4);
    area += sample.area_m2;
    middle += sample.area_m2 * sample.p_L;
  }
  EXPECT_NEAR(area, kBallArea, tolerance * kBallArea);
  EXPECT_LT((middle / area).norm(), std::min(0.1, 3.0 * tolerance) * kRadius)
      << "samples crowd on one side";
}

TEST(HandSolid, SharesOutTheSurfaceAmongEvenSamples) {
  const test::BallHand hand = chainOfBalls();
  const HandSolid solid(*hand.model, *hand.skin, Progress());
  ASSERT_EQ(solid.links().size(), 4u);
  for (const LinkSolid& link : solid.links()) {
    expectSpreadOverBall(link.coarse, 0.01);
    expectSpreadOverBall(link.fine, 0.01);
    EXPECT_NEAR(static_cast<double>(link.coarse.samples.size()), 150.0, 45.0);
    EXPECT_NEAR(static_cast<double>(link.fine.samples.size()), 1500.0, 500.0);
  }
}

TEST(HandSolid, FindsAllSamplesOfALinkNearAPlace) {
  const test::BallHand hand = chainOfBalls();
  const HandSolid solid(*hand.model, *hand.skin, Progress());
  for (const LinkSolid& link : solid.links()) {
    for (const double reach : {0.0, 0.005, 0.02, 1.0}) {
      const Vector3d place = link.centre_L + Vector3d(0.6, -0.5, 0.4) * kRadius;
      const auto is_near = [&](const Vector3d& p_L, double radius) {
        return (p_L - place).norm() <= radius + reach;
      };
      std::vector<const SurfaceSample*> visited;
      int near = 0;
      link.fine.visit(
          [&](const Vector3d& centre_L, double radius) {
            return !is_near(centre_L, radius);
          },
          [&](const SurfaceSample& sample) {
            visited.push_back(&sample);
            near += is_near(sample.p_L, 0.0) ? 1 : 0;
          });
      EXPECT_TRUE(std::is_sorted(visited.begin(), visited.end()));
      EXPECT_EQ(near, std::count_if(link.fine.samples.begin(), link.fine.samples.end(),
                                    [&](const SurfaceSample& sample) {
                                      return is_near(sample.p_L, 0.0);
                                    }));
      if (reach == 1.0) {
        EXPECT_EQ(std::ssize(visited), std::ssize(link.fine.samples));
      }
      if (reach == 0.005) {
        EXPECT_LT(std::ssize(visited), std::ssize(link.fine.samples) / 2);
      }
    }
  }
}

TEST(HandSolid, KnowsWhatALinkTakesUp) {
  const test::BallHand hand = chainOfBalls();
  const HandSolid solid(*hand.model, *hand.skin, Progress());
  for (const LinkSolid& link : solid.links()) {
    double volume = 0.0;
    for (const geometry::DistanceGrid::Cell& cell : link.cells_L)
      volume += cell.share * std::pow(link.grid_L->spacing(), 3);
    EXPECT_NEAR(volume, kBallArea * kRadius / 3.0, 0.03 * kBallArea * kRadius / 3.0);
    EXPECT_NEAR(link.distance({0.004, 0, 0}), -0.006, 3e-4);
    EXPECT_NEAR(link.distance({0, 0.0105, 0}), 0.0005, 1e-4);
  }
}

/// The same hand, its skin without what looks along x: other links might lie there.
std::shared_ptr<const Skin> skinWithGaps(const test::BallHand& hand) {
  const geometry::TriangleMesh& mesh_S = hand.skin->mesh();
  std::vector<int> links = hand.skin->faceLinks();
  for (int f = 0; f < mesh_S.faceCount(); ++f)
    if (mesh_S.faceNormals()(0, f) > 0.0) links[static_cast<std::size_t>(f)] = -1;
  return std::make_shared<const Skin>(*hand.model, mesh_S, hand.skin->qReference(),
                                      hand.skin->epsilon(), SurfaceSource::kVisuals, links);
}

TEST(HandSolid, KnowsWhatOfALinkLiesBeneathOthers) {
  const test::BallHand hand = chainOfBalls();
  const HandSolid solid(*hand.model, *skinWithGaps(hand), Progress());
  ASSERT_EQ(solid.links().size(), 4u);
  for (const LinkSolid& link : solid.links()) {
    EXPECT_NEAR(link.distance({0.6 * kRadius, 0, 0}), -0.4 * kRadius, 3e-4);
    // Some near the gap's rim may count twice, or not at all.
    expectSpreadOverBall(link.coarse, 0.1);
    expectSpreadOverBall(link.fine, 0.1);
  }
}

TEST(HandSolid, TakesTheSkinWhereALinkIsAShell) {
  const test::BallHand balls = chainOfBalls();
  std::vector<Link> links = balls.model->links();
  const geometry::TriangleMesh ball = links[0].visuals[0].mesh_L;
  // Turned inside out, it borders the hollow.
  const geometry::TriangleMesh hollow =
      geometry::transformed(ball, Eigen::Affine3d(Eigen::Scaling(-0.9, 0.9, 0.9)));
  Eigen::Matrix3Xi faces = hollow.faces();
  if (hollow.faceNormals().col(0).dot(hollow.vertex(hollow.face(0)[0])) > 0.0)
    faces.row(1).swap(faces.row(2));
  for (Link& link : links)
    link.visuals[0].mesh_L =
        geometry::merged({ball, geometry::TriangleMesh(hollow.vertices(), faces)});
  const HandModel model("shells", links, balls.model->joints());
  const HandSolid solid(model, skinOf(balls, model), Progress());
  for (const LinkSolid& link : solid.links())
    EXPECT_NEAR(link.distance({0.004, 0, 0}), -0.006, 3e-4);
}

TEST(HandSolid, TakesTheSkinWhereWallsStandWithinALink) {
  const test::BallHand balls = chainOfBalls();
  std::vector<Link> links = balls.model->links();
  const geometry::TriangleMesh ball = links[0].visuals[0].mesh_L;
  std::vector<geometry::TriangleMesh> shells = {ball};
  for (const double share : {0.8, 0.6, 0.4, 0.2})
    shells.push_back(geometry::transformed(ball, Eigen::Affine3d(Eigen::Scaling(share))));
  for (Link& link : links)
    link.visuals[0].mesh_L = geometry::merged(shells);
  const HandModel model("walls", links, balls.model->joints());
  const HandSolid solid(model, skinOf(balls, model), Progress());
  for (const LinkSolid& link : solid.links())
    EXPECT_NEAR(link.distance({0.004, 0, 0}), -0.006, 3e-4) << "a wall within is a way out";
}

// As a knuckle that its skin rounds off: no walls, hence no reason to doubt it.
TEST(HandSolid, BelievesALinkThatLacksALittleOfItsSkin) {
  const test::BallHand balls = chainOfBalls();
  std::vector<Link> links = balls.model->links();
  constexpr double kCut = 0.0065;  // m, of the ball's radius of 10 mm
  Eigen::Matrix3Xd vertices = links[0].visuals[0].mesh_L.vertices();
  vertices.row(0) = vertices.row(0).cwiseMin(kCut);
  const geometry::TriangleMesh cut(vertices, links[0].visuals[0].mesh_L.faces());
  for (Link& link : links)
    link.visuals[0].mesh_L = cut;
  const HandModel model("cut", links, balls.model->joints());
  const HandSolid solid(model, skinOf(balls, model), Progress());
  for (const LinkSolid& link : solid.links()) {
    EXPECT_EQ(link.skin_offset, 0.0) << "its own surface";
    EXPECT_NEAR(link.distance({0.009, 0, 0}), 0.009 - kCut, 3e-4);
  }
}

/// One ball, its halves two links hinged in its middle; shells within are no solids of their
/// own.
HandSolid halvesOfABall() {
  const geometry::TriangleMesh ball = geometry::makeSphere(kRadius, 4);
  std::vector<geometry::TriangleMesh> shells = {ball};
  for (const double share : {0.8, 0.6, 0.4, 0.2})
    shells.push_back(geometry::transformed(ball, Eigen::Affine3d(Eigen::Scaling(share))));
  std::vector<Link> links(2);
  for (std::size_t i = 0; i < links.size(); ++i) {
    links[i].name = "half" + std::to_string(i);
    links[i].visuals = {{geometry::merged(shells), "shells"}};
  }
  Joint joint;
  joint.name = "hinge";
  joint.type = JointType::kRevolute;
  joint.parent_link = links[0].name;
  joint.child_link = links[1].name;
  joint.axis_J = Vector3d::UnitZ();
  joint.lower = -3.0;
  joint.upper = 3.0;
  const HandModel model("halves", links, {joint});
  std::vector<int> halves;
  for (int f = 0; f < ball.faceCount(); ++f)
    halves.push_back(ball.faceNormals()(0, f) < 0.0 ? 0 : 1);
  const Skin skin(model, ball, model.restPose(), 0.004, SurfaceSource::kVisuals, halves);
  return HandSolid(model, skin, Progress());
}

TEST(HandSolid, GoesOnWhereItsSkinIsCutOffForObjectsAlone) {
  const HandSolid solid = halvesOfABall();
  ASSERT_EQ(solid.links().size(), 2u);
  for (const LinkSolid& link : solid.links()) {
    const double side = link.link == 0 ? -1.0 : 1.0;
    const Vector3d p_L(side * 0.0005, 0, 0);  // just within the cut
    EXPECT_NEAR(link.for_links_L->at(p_L) + link.skin_offset, -0.0005, 5e-4);
    // A dome 0.8 radii high: from its middle its top is the nearest.
    EXPECT_NEAR(link.distance(p_L), -0.8 * kRadius, 1e-3);
    // Beside the rim its first face is.
    EXPECT_NEAR(link.distance(side * Vector3d(0, 0.7 * kRadius, 0)), -0.267 * kRadius, 6e-4);
    EXPECT_GT(link.distance(-side * Vector3d(0.9 * kRadius, 0, 0)), 0.0);
    EXPECT_NEAR(link.distance(side * Vector3d(0.7 * kRadius, 0, 0)), -0.3 * kRadius, 5e-4);
  }
}

TEST(HandSolid, KnowsAPalmWhosePartsStandInEachOther) {
  const test::BallHand hand = test::palmOfParts(kRadius);
  const HandSolid solid(*hand.model, *skinWithGaps(hand), Progress());
  const LinkSolid& palm = solid.links().at(0);
  ASSERT_EQ(palm.link, 0);
  EXPECT_EQ(palm.skin_offset, 0.0) << "its own surface";
  EXPECT_NEAR(palm.distance({0.6 * kRadius, 0, 0}), -0.4 * kRadius, 3e-4);
  EXPECT_NEAR(palm.distance({0.1 * kRadius, 0, 0}), -0.9 * kRadius, 6e-4);
  expectSpreadOverBall(palm.fine, 0.1);
}

/// A hand of one link, whose skin is its own mesh.
HandSolid solidOf(const geometry::TriangleMesh& mesh, const HandSolidOptions& options = {}) {
  Link link;
  link.name = "link";
  link.visuals = {{mesh, "mesh"}};
  const HandModel model("hand", {link}, {});
  const Skin skin(model, mesh, model.restPose(), 0.004);
  return HandSolid(model, skin, Progress(), options);
}

double nearestSample(const SampleSet& set, const Vector3d& p_L) {
  double nearest = 1.0;
  for (const SurfaceSample& sample : set.samples)
    nearest = std::min(nearest, (sample.p_L - p_L).norm());
  return nearest;
}

TEST(HandSolid, SamplesCornersAndEdgesFirst) {
  // What stands out is the first to be in something, and grids round it.
  const geometry::TriangleMesh box = geometry::makeBox({0.02, 0.02, 0.02});
  HandSolidOptions options;
  options.fine_samples = 300;
  const HandSolid solid = solidOf(box, options);
  const SampleSet& fine = solid.links().at(0).fine;
  const double spacing = std::sqrt(0.8 * 6 * 0.02 * 0.02 / options.fine_samples);
  for (int v = 0; v < box.vertexCount(); ++v)
    EXPECT_LT(nearestSample(fine, box.vertex(v)), 1e-9) << "a corner is no sample";
  for (int i = 0; i <= 20; ++i) {
    const Vector3d edge(0.01, -0.01, -0.01 + 0.001 * i);
    EXPECT_LT(nearestSample(fine, edge), spacing);
  }
  for (const SurfaceSample& sample : fine.samples)
    EXPECT_GT(sample.area_m2, 0.0) << "a sample without weight";
}

TEST(HandSolid, SamplesEdgesMoreDenselyThanFaces) {
  // Where edges of two links cross a millimetre deep, two of each lie in the other.
  HandSolidOptions options;
  options.fine_samples = 300;  // on faces 4 mm apart
  const HandSolid solid = solidOf(geometry::makeBox({0.08, 0.03, 0.03}), options);
  const SampleSet& fine = solid.links().at(0).fine;
  for (int i = 0; i <= 160; ++i)
    EXPECT_LT(nearestSample(fine, {-0.04 + 0.0005 * i, 0.015, -0.015}), 0.0016);
  double area = 0.0;
  for (const SurfaceSample& sample : fine.samples)
    area += sample.area_m2;
  EXPECT_LT(area, 2.0 * (4 * 0.08 * 0.03 + 2 * 0.03 * 0.03)) << "edges weigh more than faces";
}

TEST(HandSolid, KnowsTheEdgesOfALargeLinkAsThoseOfASmallOne) {
  // A forearm or a robot's palm: what its grid rounds, thin things poke into unseen.
  const HandSolid solid = solidOf(geometry::makeBox({0.1, 0.08, 0.04}));
  const LinkSolid& palm = solid.links().at(0);
  for (const double depth : {0.0007, 0.001, 0.002}) {
    const Vector3d p(0.05 - depth, 0.0113, 0.02 - depth);
    EXPECT_NEAR(palm.distance(p), -depth, 6e-4) << "at an edge";
  }
  EXPECT_NEAR(palm.distance({0.011, 0.0113, 0.0195}), -5e-4, 1e-4) << "on a face";
}

TEST(HandSolid, LeavesHollowEdgesToWhatIsAround) {
  // The inner edge of an L is no place that stands out.
  const geometry::TriangleMesh upright = geometry::transformed(
      geometry::makeBox({0.01, 0.01, 0.03}), Eigen::Affine3d(Eigen::Translation3d(0, 0, 0.01)));
  const geometry::TriangleMesh lying = geometry::transformed(
      geometry::makeBox({0.03, 0.01, 0.01}), Eigen::Affine3d(Eigen::Translation3d(0.01, 0, 0)));
  const HandSolid solid = solidOf(geometry::merged({upright, lying}));
  // A corner of each box that the other one holds.
  const SampleSet& fine = solid.links().at(0).fine;
  EXPECT_GT(nearestSample(fine, {0.0049, 0, 0}), 0.001);
  EXPECT_LT(nearestSample(fine, {0.025, 0.005, 0.005}), 1e-9);
}

TEST(HandSolid, HasEnoughOfALinkThatIsAllEdges) {
  // As a noisy scan: 82,000 faces, each turned from the next.
  geometry::TriangleMesh ball = geometry::makeSphere(0.02, 6);
  Eigen::Matrix3Xd rough = ball.vertices();
  for (Eigen::Index i = 0; i < rough.cols(); ++i)
    rough.col(i) *= i % 2 == 0 ? 1.0 : 0.98;
  ball = geometry::TriangleMesh(rough, ball.faces());
  HandSolidOptions options;
  options.fine_samples = 500;
  const HandSolid solid = solidOf(ball, options);
  const SampleSet& fine = solid.links().at(0).fine;
  EXPECT_GT(fine.samples.size(), 200u);
  EXPECT_LT(fine.samples.size(), 1000u);
  for (const Vector3d& way : {Vector3d(1, 2, 3), Vector3d(-1, 0, 0.1), Vector3d(0, -1, -1)})
    EXPECT_LT(nearestSample(fine, 0.02 * way.normalized()), 0.004);
}

TEST(HandSolid, SamplesThinLinksMoreDensely) {
  // A forearm's area is not to be paid for by fingertips.
  std::vector<Link> links(2);
  links[0].name = "forearm";
  links[0].visuals = {{geometry::makeSphere(0.04, 5), "ball"}};
  links[1].name = "tip";
  links[1].visuals = {{geometry::makeSphere(0.01, 5), "ball"}};
  Joint joint;
  joint.name = "joint";
  joint.type = JointType::kRevolute;
  joint.parent_link = "forearm";
  joint.child_link = "tip";
  joint.X_PJ.translation() = Vector3d(0.1, 0, 0);
  joint.axis_J = Vector3d::UnitZ();
  const HandModel model("hand", links, {joint});
  const geometry::TriangleMesh skin = geometry::merged(
      {links[0].visuals[0].mesh_L,
       geometry::transformed(links[1].visuals[0].mesh_L,
                             Eigen::Affine3d(Eigen::Translation3d(0.1, 0, 0)))});
  const HandSolid solid(model, Skin(model, skin, model.restPose(), 0.004), Progress(),
                        {200, 1000});
  const auto density = [&](std::size_t k, double radius) {
    return static_cast<double>(solid.links().at(k).fine.samples.size()) / (radius * radius);
  };
  // What bulges between samples is as their distance squared by the radius.
  EXPECT_NEAR(density(1, 0.01) / density(0, 0.04), 4.0, 1.0);
}

TEST(HandSolid, LeavesOutNeighboursAndWhatTouchesAtRest) {
  const test::BallHand hand = chainOfBalls();
  const HandSolid solid(*hand.model, *hand.skin, Progress());
  const std::vector<std::array<int, 2>> expected = {{0, 2}, {0, 3}, {1, 3}};
  EXPECT_EQ(solid.collisionPairs(), expected);

  // Folded so that balls 0 and 3 meet at rest.
  const HandModel folded = hand.model->withRestPose(Vector3d::Constant(1.9));
  const std::vector<std::array<int, 2>> fewer = {{0, 2}, {1, 3}};
  EXPECT_EQ(HandSolid(folded, *hand.skin, Progress()).collisionPairs(), fewer);
}

TEST(HandSolid, TakesJointsInOnePlaceForOne) {
  const test::BallHand far = chainOfBalls();
  std::vector<Joint> joints = far.model->joints();
  // The second and the third joint as the two axes of a knuckle, 6 mm apart.
  joints[1].X_PJ.translation() = Vector3d(0.006, 0, 0);
  const test::BallHand near =
      test::withBalls(HandModel("near", far.model->links(), joints), kRadius);
  const std::vector<std::array<int, 2>> strangers =
      HandSolid(*near.model, *near.skin, Progress()).collisionPairs();
  EXPECT_THAT(strangers, testing::Not(testing::Contains(std::array<int, 2>{0, 2})));
  EXPECT_THAT(strangers, testing::Contains(std::array<int, 2>{0, 3}));
}

TEST(HandSolid, MeasuresHowDeepLinksLieInEachOther) {
  const test::BallHand hand = chainOfBalls();
  const HandSolid solid(*hand.model, *hand.skin, Progress());
  for (const double distance : {0.012, 0.018, 0.0199, 0.021, 0.5}) {
    Pose X_BA = Pose::Identity();
    X_BA.translation() = distance * Vector3d(2, -1, 0.5).normalized();
    const double depth = depthOf(solid.links()[0], solid.links()[3], X_BA);
    EXPECT_NEAR(depth, std::max(0.0, 2 * kRadius - distance), distance < 0.015 ? 1e-3 : 3e-4)
        << distance;
  }
}

TEST(HandSolid, IsTheSameBytesTwice) {
  const test::BallHand hand = chainOfBalls();
  const HandSolid one(*hand.model, *hand.skin, Progress());
  const HandSolid two(*hand.model, *hand.skin, Progress());
  for (std::size_t k = 0; k < one.links().size(); ++k) {
    const auto& a = one.links()[k].coarse.samples;
    const auto& b = two.links()[k].coarse.samples;
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
      EXPECT_EQ(a[i].p_L, b[i].p_L);
      EXPECT_EQ(a[i].area_m2, b[i].area_m2);
    }
  }
}

TEST(HandSolid, StopsOnWish) {
  const test::BallHand hand = chainOfBalls();
  Progress progress;
  progress.cancel();
  EXPECT_THROW(HandSolid(*hand.model, *hand.skin, progress), Cancelled);
}

TEST(SampleThinning, KeepsAllAtADistanceAndEveryoneNearOne) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> side(0.0, 0.1);
  Eigen::Matrix3Xd points(3, 3000);
  std::vector<int> groups;
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    for (int a = 0; a < 3; ++a)
      points(a, i) = side(random);
    groups.push_back(static_cast<int>(i % 2));
  }
  const double spacing = 0.02;
  const geometry::Thinned thinned = geometry::thinOut(points, groups, spacing);
  for (const int a : thinned.kept) {
    for (const int b : thinned.kept) {
      if (a < b && groups[a] == groups[b]) {
        EXPECT_GE((points.col(a) - points.col(b)).norm(), spacing);
      }
    }
  }
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    const int nearest = thinned.kept.at(thinned.nearest[i]);
    EXPECT_EQ(groups[nearest], groups[i]);
    double best = 1.0;
    for (const int k : thinned.kept)
      if (groups[k] == groups[i]) best = std::min(best, (points.col(k) - points.col(i)).norm());
    EXPECT_EQ((points.col(nearest) - points.col(i)).norm(), best);
    EXPECT_LT(best, spacing);
  }
}

}  // namespace
}  // namespace handgraft::hand
