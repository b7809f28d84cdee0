#include "core/quality/penetration.h"

#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "tests/support/ball_hand.h"

namespace handgraft::quality {
namespace {

using Eigen::Vector3d;

constexpr double kBall = 0.02;  // m

std::shared_ptr<const geometry::Solid> solidOf(const geometry::TriangleMesh& mesh) {
  return std::make_shared<const geometry::Solid>(mesh, Progress());
}

/// Four balls in a row along x, 50 mm apart, hinged about z.
struct Chain {
  test::BallHand hand;
  std::unique_ptr<hand::HandSolid> solid;

  Chain() {
    std::vector<hand::Link> links(4);
    std::vector<hand::Joint> joints;
    for (std::size_t i = 0; i < links.size(); ++i) {
      links[i].name = "link" + std::to_string(i);
      if (i == 0) continue;
      hand::Joint joint;
      joint.name = "joint" + std::to_string(i);
      joint.type = hand::JointType::kRevolute;
      joint.parent_link = links[i - 1].name;
      joint.child_link = links[i].name;
      joint.X_PJ.translation() = Vector3d(0.05, 0, 0);
      joint.axis_J = Vector3d::UnitZ();
      joints.push_back(joint);
    }
    hand = test::withBalls(hand::HandModel("chain", links, joints), kBall);
    solid = std::make_unique<hand::HandSolid>(*hand.model, *hand.skin, Progress());
  }

  [[nodiscard]] hand::HandPose straight() const {
    return {Pose::Identity(), Eigen::VectorXd::Zero(3)};
  }
};

const Chain& chain() {
  static const Chain the_chain;
  return the_chain;
}

Pose at(const Vector3d& p) {
  Pose X = Pose::Identity();
  X.linear() = rotationFromVector({0.2, 0.4, -0.3});
  X.translation() = p;
  return X;
}

Penetration measure(const geometry::Solid& object_O,
                    const Pose& X_WO,
                    const hand::HandPose& pose) {
  return measurePenetration(*chain().hand.model, *chain().solid, object_O, X_WO, pose);
}

/// One link.
hand::HandModel handOfABox(const Vector3d& size) {
  std::vector<hand::Link> links(1);
  links[0].name = "box";
  links[0].visuals = {{geometry::makeBox(size), "box"}};
  return {"box", links, {}};
}

hand::Skin skinOfABox(const hand::HandModel& model) {
  return {model, model.links()[0].visuals[0].mesh_L, Eigen::VectorXd(), 0.004};
}

TEST(Penetration, IsNothingForAHandThatTouchesNothing) {
  const auto ball_O = solidOf(geometry::makeSphere(0.03, 4));
  const Penetration apart = measure(*ball_O, at({0, 0.0501, 0}), chain().straight());
  EXPECT_EQ(apart.max_depth_m, 0.0);
  EXPECT_EQ(apart.mean_depth_m, 0.0);
  EXPECT_LT(apart.volume_m3, 1e-9);
  EXPECT_TRUE(apart.links.empty());
  EXPECT_EQ(apart.self_depth_m, 0.0);
}

TEST(Penetration, HasTheDepthAndTheVolumeOfALensOfTwoBalls) {
  const double r = kBall;
  const double big = 0.03;
  const auto ball_O = solidOf(geometry::makeSphere(big, 5));
  for (const double d : {0.048, 0.043, 0.035, 0.025}) {
    const Penetration found = measure(*ball_O, at({0, -d, 0}), chain().straight());
    EXPECT_NEAR(found.max_depth_m, r + big - d, 2e-4) << d;
    // Weisstein, "Sphere-Sphere Intersection", equation 16.
    const double lens = std::numbers::pi * std::pow(r + big - d, 2) *
                        (d * d + 2 * d * (r + big) - 3 * (r - big) * (r - big)) / (12 * d);
    EXPECT_NEAR(found.volume_m3, lens, 0.03 * lens + 1e-8) << d;
    ASSERT_EQ(found.links.size(), 1u);
    EXPECT_EQ(found.links[0].link, 0);
    EXPECT_GT(found.mean_depth_m, 0.3 * found.max_depth_m);
    EXPECT_LT(found.mean_depth_m, 0.7 * found.max_depth_m);
  }
}

// No place of the link's surface lies in it.
TEST(Penetration, OfAnObjectWithinALinkIsTold) {
  const double small = 0.6 * kBall;
  const auto ball_O = solidOf(geometry::makeSphere(small, 4));
  const Penetration found = measure(*ball_O, at({0, 0.001, 0}), chain().straight());
  ASSERT_EQ(found.links.size(), 1u);
  EXPECT_EQ(found.links[0].link, 0);
  // Its middle is as deep as it is thick; cells are 1 to 2 mm apart.
  EXPECT_GT(found.max_depth_m, small - 0.003);
  EXPECT_LT(found.max_depth_m, small + 1e-4);
}

TEST(Penetration, HasTheVolumeThatTwoBoxesShare) {
  const Vector3d size(0.05, 0.04, 0.03);
  const hand::HandModel model = handOfABox(size);
  const hand::HandSolid solid(model, skinOfABox(model), Progress());
  const auto box_O = solidOf(geometry::makeBox({0.06, 0.06, 0.06}));
  const hand::HandPose pose{Pose::Identity(), Eigen::VectorXd()};
  for (const Vector3d& way : {Vector3d(0.045, 0, 0), Vector3d(0.04, 0.03, 0.02)}) {
    Pose X_WO = Pose::Identity();
    X_WO.translation() = way;
    const Vector3d shared = (0.5 * (size + Vector3d::Constant(0.06)) - way).cwiseMin(size);
    const double volume = shared.prod();
    EXPECT_NEAR(measurePenetration(model, solid, *box_O, X_WO, pose).volume_m3, volume,
                0.03 * volume);
  }
}

/// Tips between the samples of a flat link, where no edge of them is sharp.
TEST(Penetration, OfATipIsToldWhereverItMeetsALink) {
  constexpr double kDeep = 0.002;
  constexpr double kHeight = 0.12;
  constexpr int kSides = 96;
  Eigen::Matrix3Xd vertices(3, kSides + 2);
  Eigen::Matrix3Xi faces(3, 2 * kSides);
  for (int i = 0; i < kSides; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / kSides;
    vertices.col(i) << 0.06 * std::cos(angle), 0.06 * std::sin(angle), 0.0;
    faces.col(2 * i) << i, (i + 1) % kSides, kSides;
    faces.col(2 * i + 1) << (i + 1) % kSides, i, kSides + 1;
  }
  vertices.col(kSides) << 0.0, 0.0, kHeight;
  vertices.col(kSides + 1).setZero();
  const auto cone_O = solidOf({vertices, faces});

  const Vector3d size(0.05, 0.04, 0.03);
  const hand::HandModel model = handOfABox(size);
  const hand::HandSolid solid(model, skinOfABox(model), Progress());
  const hand::HandPose pose{Pose::Identity(), Eigen::VectorXd()};
  for (const double x : {-0.011, 0.0, 0.0013, 0.0049}) {
    Pose X_WO = Pose::Identity();
    X_WO.translation() << x, 0.37 * x, -0.5 * size.z() - kHeight + kDeep;
    EXPECT_NEAR(measurePenetration(model, solid, *cone_O, X_WO, pose).max_depth_m, kDeep, 1e-4)
        << x;
  }
}

// === Walls: the first ball of the chain, of radius r, its centre at height h over them

/// A rectangle of one layer in the plane y = 0, in small triangles.
geometry::TriangleMesh makeSheet(double length_x, double length_z) {
  constexpr int kCells = 8;
  Eigen::Matrix3Xd vertices(3, (kCells + 1) * (kCells + 1));
  Eigen::Matrix3Xi faces(3, 2 * kCells * kCells);
  int face = 0;
  for (int i = 0; i <= kCells; ++i) {
    for (int j = 0; j <= kCells; ++j) {
      const int v = i * (kCells + 1) + j;
      vertices.col(v) << length_x * (1.0 * i / kCells - 0.5), 0.0,
          length_z * (1.0 * j / kCells - 0.5);
      if (i == kCells || j == kCells) continue;
      faces.col(face++) << v, v + 1, v + kCells + 1;
      faces.col(face++) << v + 1, v + kCells + 2, v + kCells + 1;
    }
  }
  return {vertices, faces};
}

/// A cylinder about x without one of its caps.
geometry::TriangleMesh makeCup(double radius, double length) {
  const geometry::TriangleMesh whole = geometry::makeCylinder(radius, length, 96);
  const Eigen::Matrix3d R_XZ = rotationFromVector({0.0, 0.5 * std::numbers::pi, 0.0});
  std::vector<Eigen::Vector3i> kept;
  for (int f = 0; f < whole.faceCount(); ++f)
    if (whole.faceNormals()(2, f) < 0.9) kept.push_back(whole.face(f));
  Eigen::Matrix3Xi faces(3, std::ssize(kept));
  for (Eigen::Index f = 0; f < faces.cols(); ++f)
    faces.col(f) = kept[static_cast<std::size_t>(f)];
  return {R_XZ * whole.vertices(), faces};
}

/// With the object unturned at `p_WO`, and contacts of the first ball looking along `n_O` at
/// `p_O`, if there are any.
double depthAt(const geometry::Solid& object_O,
               const Vector3d& p_WO,
               const Vector3d& p_O,
               const Vector3d& n_O) {
  Pose X_WO = Pose::Identity();
  X_WO.translation() = p_WO;
  std::vector<ContactSide> sides;
  if (n_O.norm() > 0.0) sides.push_back({0, p_O, n_O});
  const Penetration found = measurePenetration(*chain().hand.model, *chain().solid, object_O,
                                               X_WO, chain().straight(), sides);
  EXPECT_TRUE(found.links.empty() || found.links.front().link == 0);
  return found.max_depth_m;
}

constexpr double kWallTolerance = 6e-4;  // m; samples 2.5 mm apart, grids of 1-2 mm

TEST(Penetration, OfASheetIsTheWayBackToItsSide) {
  const auto sheet_O = solidOf(makeSheet(0.05, 0.1));
  for (const double h : {0.015, 0.005, -0.005, -0.015}) {
    const Vector3d p_WO(0, -h, 0);
    EXPECT_NEAR(depthAt(*sheet_O, p_WO, {0, 0, 0}, {0, 1, 0}), kBall - h, kWallTolerance) << h;
    EXPECT_NEAR(depthAt(*sheet_O, p_WO, {0, 0, 0}, {0, -1, 0}), kBall + h, kWallTolerance) << h;
    EXPECT_NEAR(depthAt(*sheet_O, p_WO, {0, 0, 0}, {0, 0, 0}), kBall - std::abs(h),
                kWallTolerance)
        << h;
  }
  EXPECT_EQ(depthAt(*sheet_O, {0, -0.0205, 0}, {0, 0, 0}, {0, 1, 0}), 0.0);
}

TEST(Penetration, OfAPlateIsNotHalfItsThickness) {
  const double t = 0.004;
  const auto plate_O = solidOf(geometry::makeBox({0.05, t, 0.1}));
  for (const double h : {0.012, 0.004, -0.002, -0.008}) {  // over the upper side
    const Vector3d p_WO(0, -h - 0.5 * t, 0);
    EXPECT_NEAR(depthAt(*plate_O, p_WO, {0, 0.5 * t, 0}, {0, 1, 0}), kBall - h, kWallTolerance)
        << h;
    EXPECT_NEAR(depthAt(*plate_O, p_WO, {0, 0, 0}, {0, 0, 0}),
                std::min(kBall - h, kBall + h + t), kWallTolerance)
        << h;
  }
  // Not through: half a millimetre into a side, as in any solid.
  EXPECT_NEAR(depthAt(*plate_O, {0, -0.0195 - 0.5 * t, 0}, {0, 0, 0}, {0, 0, 0}), 0.0005, 2e-4);
}

TEST(Penetration, KnowsTheInsideOfACupFromItsWall) {
  const double radius = 0.03;
  const auto cup_O = solidOf(makeCup(radius, 0.05));
  EXPECT_EQ(depthAt(*cup_O, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}), 0.0) << "a cup is not full";
  for (const double off : {0.012, 0.02, 0.028}) {  // of the ball's centre from the cup's axis
    const Vector3d p_WO(0, -off, 0);
    const Vector3d wall_O(0, radius, 0);
    EXPECT_NEAR(depthAt(*cup_O, p_WO, wall_O, {0, -1, 0}), off + kBall - radius, kWallTolerance)
        << off;
    EXPECT_NEAR(depthAt(*cup_O, p_WO, wall_O, {0, 1, 0}), radius + kBall - off, kWallTolerance)
        << off;
  }
}

TEST(Penetration, RanksLinksByDepth) {
  const auto ball_O = solidOf(geometry::makeSphere(0.03, 4));
  const Penetration found = measure(*ball_O, at({0.072, 0.03, 0}), chain().straight());
  ASSERT_EQ(found.links.size(), 2u);
  EXPECT_EQ(found.links[0].link, 1);
  EXPECT_EQ(found.links[1].link, 2);
  EXPECT_GT(found.links[0].depth_m, found.links[1].depth_m);
  EXPECT_EQ(found.links[0].depth_m, found.max_depth_m);
}

TEST(Penetration, DoesNotMindWhereTheWorldIs) {
  const auto ball_O = solidOf(geometry::makeSphere(0.03, 4));
  const Penetration here = measure(*ball_O, at({0, 0.04, 0}), chain().straight());
  const Pose X = at({3, -2, 1});
  hand::HandPose pose = chain().straight();
  pose.X_WH = X * pose.X_WH;
  const Penetration there = measure(*ball_O, X * at({0, 0.04, 0}), pose);
  EXPECT_NEAR(there.max_depth_m, here.max_depth_m, 1e-12);
  EXPECT_NEAR(there.volume_m3, here.volume_m3, 1e-9 * here.volume_m3);
}

TEST(Penetration, TellsWhichLinksLieInEachOther) {
  const auto ball_O = solidOf(geometry::makeSphere(0.01, 3));
  hand::HandPose pose = chain().straight();
  // Nearly an equilateral way round, which would bring the last ball back to the first.
  pose.q << 2.0, 2.0, 0.0;
  const Penetration found = measure(*ball_O, at({1, 1, 1}), pose);
  const hand::LinkPoses X_WL = forwardKinematics(*chain().hand.model, pose);
  const double apart = (X_WL[3].translation() - X_WL[0].translation()).norm();
  const double depth = kBall - std::abs(kBall - apart);  // of the one's deepest place
  ASSERT_GT(depth, 0.005);
  EXPECT_NEAR(found.self_depth_m, depth, 1.5e-3);
  EXPECT_EQ(found.self_links, (std::array<int, 2>{0, 3}));
  EXPECT_EQ(found.max_depth_m, 0.0);
}

TEST(Penetration, DepthsAloneAreThoseOfTheWhole) {
  const auto ball_O = solidOf(geometry::makeSphere(0.03, 4));
  const Pose X_WO = at({0, 0.04, 0});
  Depths deepest;
  for (const double bend : {0.0, 1.0, 2.0}) {
    hand::HandPose pose = chain().straight();
    pose.q << bend, bend, 0.0;
    const Penetration whole = measure(*ball_O, X_WO, pose);
    pose.X_WH = inverse(X_WO) * pose.X_WH;
    const Depths depths =
        measureDepths(*chain().hand.model, *chain().solid, *ball_O, pose, Progress());
    EXPECT_NEAR(depths.object_m, whole.max_depth_m, 1e-12) << bend;
    EXPECT_NEAR(depths.self_m, whole.self_depth_m, 1e-12) << bend;
    deepest = deeperOf(deepest, depths);
  }
  EXPECT_GT(deepest.object_m, 0.005);
  EXPECT_GT(deepest.self_m, 0.005);
}

TEST(Penetration, TheDeepestIsFoundAmongManyThatTouch) {
  // Plain measuring, at each sample; a tenth of a millimetre decides which of them is deepest.
  std::mt19937 random(3);
  std::uniform_real_distribution<double> depth(-3e-4, 2e-3);
  std::normal_distribution<double> turn;
  const hand::HandModel model = handOfABox({0.03, 0.02, 0.02});
  const hand::Skin skin = skinOfABox(model);
  const hand::HandSolid solid(model, skin, Progress());
  for (const geometry::TriangleMesh& mesh :
       {geometry::makeBox({0.2, 0.2, 0.05}), geometry::makeSphere(0.05, 5)}) {
    const auto object_O = solidOf(mesh);
    const double top = mesh.vertices().row(2).maxCoeff();
    int inside = 0;
    for (int k = 0; k < 40; ++k) {
      hand::HandPose X_OH;
      X_OH.X_WH.linear() =
          rotationFromVector({0.02 * turn(random), 0.02 * turn(random), 0.02 * turn(random)});
      X_OH.X_WH.translation() = Vector3d(0.04 * (k % 2), 0.0, top + 0.01 - depth(random));
      double deepest = 0.0;
      for (const hand::SurfaceSample& sample : solid.links()[0].fine.samples) {
        const double distance = object_O->grid().exact().at(X_OH.X_WH * sample.p_L).distance;
        deepest = std::max(deepest, -distance);
      }
      const double told = measureDepth(model, solid, *object_O, X_OH, Progress());
      // Walls and rounding of a touch come on top.
      EXPECT_GE(told, deepest - 1e-6);
      EXPECT_LE(told, deepest + 2e-4);
      inside += deepest > 1e-5 ? 1 : 0;
    }
    EXPECT_GT(inside, 10);
  }
}

}  // namespace
}  // namespace handgraft::quality
