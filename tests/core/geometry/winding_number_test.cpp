#include "core/geometry/winding_number.h"

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "tests/core/geometry/solids.h"

namespace handgraft::geometry {
namespace {

using Eigen::Vector3d;
using test::randomIn;

/// Face by face, without a tree, by van Oosterom & Strackee 1983.
double summedUp(const TriangleMesh& mesh, const Vector3d& p) {
  double sum = 0.0;
  for (int f = 0; f < mesh.faceCount(); ++f) {
    const Vector3d a = mesh.vertex(mesh.face(f)[0]) - p;
    const Vector3d b = mesh.vertex(mesh.face(f)[1]) - p;
    const Vector3d c = mesh.vertex(mesh.face(f)[2]) - p;
    const double below = a.norm() * b.norm() * c.norm() + a.dot(b) * c.norm() +
                         b.dot(c) * a.norm() + c.dot(a) * b.norm();
    sum += 2.0 * std::atan2(a.dot(b.cross(c)), below);
  }
  return sum / (4.0 * std::numbers::pi);
}

TriangleMesh movedBy(const TriangleMesh& mesh, const Vector3d& by) {
  return transformed(mesh, Eigen::Affine3d(Eigen::Translation3d(by)));
}

TEST(WindingNumber, OfOverlappingSolidsIsHowManyHoldAPlace) {
  const Vector3d apart(0.03, 0.0, 0.0);
  const TriangleMesh ball = makeSphere(0.02, 4);
  const TriangleMesh mesh =
      merged({movedBy(ball, -0.5 * apart), movedBy(ball, 0.5 * apart), makeBox({1, 1, 1})});
  const WindingNumber winding(mesh);
  std::mt19937 random(3);
  for (int i = 0; i < 500; ++i) {
    const Vector3d p = randomIn(0.05, random);
    int count = 1;  // the box
    bool is_near_a_border = false;
    for (const double side : {-0.5, 0.5}) {
      const double distance = (p - side * apart).norm();
      count += distance < 0.02 ? 1 : 0;
      is_near_a_border = is_near_a_border || std::abs(distance - 0.02) < 2e-4;
    }
    if (is_near_a_border) continue;
    EXPECT_NEAR(winding.at(p), count, 0.05) << p.transpose();
  }
}

TEST(WindingNumber, IsTheSumOverFacesOfAnOpenMeshToo) {
  const TriangleMesh ball = makeSphere(0.02, 3);
  const TriangleMesh bowl(ball.vertices(), ball.faces().leftCols(ball.faceCount() * 3 / 5));
  // Closed pieces beside it, so that both kinds stand in one tree.
  const TriangleMesh mesh = merged({movedBy(ball, {0.05, 0.0, 0.0}), bowl,
                                    movedBy(makeBox({0.01, 0.02, 0.03}), {0.0, 0.05, 0.0})});
  const WindingNumber winding(mesh);
  std::mt19937 random(4);
  for (int i = 0; i < 500; ++i) {
    const Vector3d p = randomIn(0.08, random);
    EXPECT_NEAR(winding.at(p), summedUp(mesh, p), 0.03) << p.transpose();
  }
}

TEST(WindingNumber, ClosedPiecesCountNothingOutsideTheirBoxes) {
  std::vector<TriangleMesh> balls;
  std::mt19937 random(5);
  for (int i = 0; i < 50; ++i)
    balls.push_back(movedBy(makeSphere(0.01, 2), randomIn(0.2, random)));
  const WindingNumber winding(merged(balls));
  EXPECT_EQ(winding.at({0.3, 0.0, 0.0}), 0.0);
  EXPECT_EQ(winding.at({0.0, -0.25, 0.1}), 0.0);
}

TEST(WindingNumber, TurnsRoundWithTheFaces) {
  const TriangleMesh box = makeBox({0.02, 0.02, 0.02});
  Eigen::Matrix3Xi turned = box.faces();
  turned.row(1).swap(turned.row(2));
  EXPECT_NEAR(WindingNumber(box).at({0.001, 0.002, 0.003}), 1.0, 1e-12);
  EXPECT_NEAR(WindingNumber({box.vertices(), turned}).at({0.001, 0.002, 0.003}), -1.0, 1e-12);
}

TEST(WindingNumber, IsANumberOnCornersEdgesAndFaces) {
  const TriangleMesh box = makeBox({0.02, 0.02, 0.02});
  const WindingNumber winding(box);
  for (const double x : {-0.01, 0.0, 0.01})
    for (const double y : {-0.01, 0.0, 0.01})
      for (const double z : {-0.01, 0.0, 0.01}) {
        const double number = winding.at({x, y, z});
        EXPECT_GE(number, -1e-12) << x << ' ' << y << ' ' << z;
        EXPECT_LE(number, 1.0 + 1e-12) << x << ' ' << y << ' ' << z;
      }
}

TEST(WindingNumber, HoldsForAnySizeOfNumbers) {
  for (const double size : {1e-60, 1e-12, 1.0, 1e12, 1e60}) {
    const WindingNumber winding(makeSphere(size, 3));
    EXPECT_NEAR(winding.at(Vector3d(0.1, 0.2, 0.3) * size), 1.0, 0.03) << size;
    EXPECT_NEAR(winding.at(Vector3d(0.7, 0.8, 0.3) * size), 0.0, 0.03) << size;
  }
}

}  // namespace
}  // namespace handgraft::geometry
