#include "core/geometry/inward_faces.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/geometry/signed_distance.h"

namespace handgraft::geometry {
namespace {

TriangleMesh insideOut(const TriangleMesh& mesh) {
  return withTurnedFaces(mesh,
                         std::vector<char>(static_cast<std::size_t>(mesh.faceCount()), 1));
}

TriangleMesh at(const Eigen::Vector3d& p, const TriangleMesh& mesh) {
  return transformed(mesh, Eigen::Affine3d(Eigen::Translation3d(p)));
}

TriangleMesh mended(const TriangleMesh& mesh) {
  const std::vector<char> turned = inwardFaces(mesh);
  return turned.empty() ? mesh : withTurnedFaces(mesh, turned);
}

/// A cube of 60 mm with a roof half as high: nothing symmetric.
TriangleMesh house() {
  return merged({makeBox({0.06, 0.05, 0.04}), at({0.0, 0.0, 0.05}, makeSphere(0.02, 2))});
}

/// A ball of 30 mm with a hole of 15 mm in it.
TriangleMesh hollowBall() {
  return merged({makeSphere(0.03, 3), insideOut(makeSphere(0.015, 2))});
}

TEST(InwardFaces, SolidsThatLookOutwardsAreLeft) {
  for (const TriangleMesh& mesh :
       {house(), hollowBall(), makeCylinder(0.02, 0.1), makeBox({0.1, 0.1, 0.001}),
        merged({hollowBall(), makeSphere(0.01, 2)}),
        merged({makeSphere(0.03, 3), makeSphere(0.015, 2)})}) {
    EXPECT_TRUE(inwardFaces(mesh).empty());
  }
}

TEST(InwardFaces, SolidsTurnedInsideOutAreTurnedBack) {
  for (const TriangleMesh& mesh : {house(), hollowBall(), makeCylinder(0.02, 0.1),
                                   merged({hollowBall(), makeSphere(0.01, 2)}),
                                   merged({makeSphere(0.03, 3), makeSphere(0.015, 2)})}) {
    EXPECT_EQ(mended(insideOut(mesh)).faces(), mesh.faces());
  }
}

TEST(InwardFaces, OnePartOfSeveralMayBeInsideOut) {
  const TriangleMesh ball = at({0.1, 0.0, 0.0}, makeSphere(0.02, 2));
  const TriangleMesh right = merged({makeBox({0.06, 0.05, 0.04}), ball});
  EXPECT_EQ(mended(merged({makeBox({0.06, 0.05, 0.04}), insideOut(ball)})).faces(),
            right.faces());
}

TEST(InwardFaces, FacesThatDisagreeGiveWayToMostOfTheArea) {
  for (const TriangleMesh& mesh :
       {house(), makeSphere(0.03, 3), insideOut(makeSphere(0.03, 3))}) {
    std::vector<char> some(static_cast<std::size_t>(mesh.faceCount()), 0);
    for (std::size_t f = 0; f < some.size(); f += 3)
      some[f] = 1;
    const TriangleMesh right = mended(withTurnedFaces(mesh, some));
    EXPECT_TRUE(right.isClosed());
    EXPECT_EQ(right.faces(), mended(mesh).faces());
  }
}

/// Half a sphere, its rim far wider than a finger: nobody can say which of its sides is meant.
TEST(InwardFaces, ASheetKeepsItsSide) {
  const TriangleMesh ball = makeSphere(0.03, 3);
  std::vector<int> upper;
  for (int f = 0; f < ball.faceCount(); ++f)
    if (ball.vertex(ball.face(f)[0]).z() > 0.0) upper.push_back(f);
  const TriangleMesh bowl(ball.vertices(), ball.faces()(Eigen::all, upper));
  EXPECT_TRUE(inwardFaces(bowl).empty());
  EXPECT_TRUE(inwardFaces(insideOut(bowl)).empty());
  std::vector<char> one(upper.size(), 0);
  one[upper.size() / 2] = 1;
  EXPECT_EQ(inwardFaces(withTurnedFaces(bowl, one)), one);
}

/// Scans have small holes, at the bottom most often.
TEST(InwardFaces, ASolidWithASmallHoleIsOneStill) {
  const TriangleMesh ball = makeSphere(0.03, 4);
  std::vector<int> most;
  for (int f = 0; f < ball.faceCount(); ++f)
    if (ball.vertex(ball.face(f)[0]).z() > -0.0295) most.push_back(f);
  ASSERT_LT(std::ssize(most), ball.faceCount());
  const TriangleMesh scan(ball.vertices(), ball.faces()(Eigen::all, most));
  EXPECT_TRUE(inwardFaces(scan).empty());
  EXPECT_EQ(mended(insideOut(scan)).faces(), scan.faces());
}

TEST(InwardFaces, WhatHoldsNothingIsLeft) {
  EXPECT_TRUE(inwardFaces(TriangleMesh()).empty());
  const Eigen::Matrix3Xd corners = Eigen::Matrix3d::Identity();
  Eigen::Matrix3Xi both(3, 2);
  both << 0, 0, 1, 2, 2, 1;
  EXPECT_TRUE(inwardFaces(TriangleMesh(corners, both)).empty());
}

}  // namespace
}  // namespace handgraft::geometry
