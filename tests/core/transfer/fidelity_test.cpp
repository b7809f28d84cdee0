#include "core/transfer/fidelity.h"

#include <cmath>
#include <functional>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/geometry/tangent.h"
#include "core/transfer/patch_transfer.h"

#include "tests/support/plate_hand.h"
#include "tests/support/plates.h"

namespace handgraft::transfer {
namespace {

using geometry::TriangleMesh;

constexpr double kPi = std::numbers::pi;
constexpr int kCount = 24;
constexpr int kRows = 5;  // the root, three rings, the boundary

using Place = std::function<Eigen::Vector3d(double r, double phi)>;

/// A net in polar coordinates, laid onto two surfaces.
std::vector<std::vector<NetKnot>> netOf(double radius, const Place& object, const Place& skin) {
  std::vector<std::vector<NetKnot>> rows(kRows);
  for (int row = 0; row < kRows; ++row) {
    for (int i = 0; i < kCount; ++i) {
      const double r = radius * row / (kRows - 1);
      const double phi = 2.0 * kPi * i / kCount;
      rows[row].push_back({true, object(r, phi), skin(r, phi)});
    }
  }
  return rows;
}

Place plane(double scale = 1.0) {
  return [=](double r, double phi) {
    return Eigen::Vector3d(scale * r * std::cos(phi), scale * r * std::sin(phi), 0.0);
  };
}

Place sphere(double R) {
  return [=](double r, double phi) {
    return Eigen::Vector3d(R * std::sin(r / R) * std::cos(phi),
                           R * std::sin(r / R) * std::sin(phi), R * std::cos(r / R));
  };
}

TEST(Fidelity, IsPerfectBetweenSurfacesThatAreTheSame) {
  const Fidelity fidelity = fidelityOf(netOf(0.02, sphere(0.03), sphere(0.03)));
  EXPECT_EQ(fidelity.distance_max, 0.0);
  EXPECT_EQ(fidelity.angle_max_rad, 0.0);
  EXPECT_EQ(fidelity.area_ratio, 1.0);
}

TEST(Fidelity, TellsAScaleAsDistanceAndAreaAndNoAngle) {
  const Fidelity fidelity = fidelityOf(netOf(0.02, plane(), plane(1.3)));
  EXPECT_NEAR(fidelity.distance_mean, 0.3, 1e-12);
  EXPECT_NEAR(fidelity.distance_max, 0.3, 1e-12);
  EXPECT_NEAR(fidelity.angle_max_rad, 0.0, 1e-12);
  EXPECT_NEAR(fidelity.area_ratio, 1.69, 1e-12);
}

TEST(Fidelity, TellsAShearByTheAnglesOfItsTriangles) {
  // One ring of a square about its middle, sheared to a rhombus: x += y / 2.
  std::vector<std::vector<NetKnot>> rows(2);
  const Eigen::Vector3d corners[] = {{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}};
  for (const Eigen::Vector3d& p : corners) {
    rows[0].push_back({true, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()});
    rows[1].push_back({true, p, p + 0.5 * p.y() * Eigen::Vector3d::UnitX()});
  }
  const Fidelity fidelity = fidelityOf(rows);
  // At the middle, between (1, 0) and (1/2, 1): atan(2) instead of a right angle.
  EXPECT_NEAR(fidelity.angle_max_rad, kPi / 2 - std::atan(2.0), 1e-12);
  EXPECT_NEAR(fidelity.area_ratio, 1.0, 1e-12);
}

TEST(Fidelity, FromAPlaneToASphereIsThatOfItsCircles) {
  // Radii keep their length (arcs; chords here), circles shrink by sin(a) / a, a = r / R.
  const double R = 0.03;
  const double radius = 0.018;
  const Fidelity fidelity = fidelityOf(netOf(radius, plane(), sphere(R)));
  const double a = radius / R;
  EXPECT_NEAR(fidelity.distance_max, 1.0 - std::sin(a) / a, 1e-12);
  // 2 pi R^2 (1 - cos a) against pi r^2; facets of 15 degrees and a quarter of r take 0.5 %.
  EXPECT_NEAR(fidelity.area_ratio, 2.0 * (1.0 - std::cos(a)) / (a * a), 0.005);
}

TEST(Fidelity, IsToldWhereAPatchDoesNotKeepItsShape) {
  EXPECT_EQ(distortionOf(fidelityOf(netOf(0.02, plane(), plane(1.1)))), "");
  EXPECT_EQ(distortionOf(fidelityOf(netOf(0.02, plane(), plane(1.3)))),
            "lengths 30 %, angles 0 deg, area x 1.69");
  Fidelity turned;
  turned.angle_mean_rad = 0.3;
  EXPECT_THAT(distortionOf(turned), testing::HasSubstr("angles 17 deg"));
}

TEST(Fidelity, LeavesOutWhatIsLost) {
  std::vector<std::vector<NetKnot>> rows = netOf(0.02, plane(), plane());
  rows.back()[3] = {};
  rows[2][7] = {};
  const Fidelity fidelity = fidelityOf(rows);
  EXPECT_NEAR(fidelity.distance_max, 0.0, 1e-12);
  EXPECT_NEAR(fidelity.area_ratio, 1.0, 1e-12);
  for (std::vector<NetKnot>& row : rows) {
    for (NetKnot& knot : row)
      knot.valid = false;
  }
  EXPECT_EQ(fidelityOf(rows).area_ratio, 1.0);
  EXPECT_EQ(fidelityOf(rows).distance_mean, 0.0);
  EXPECT_EQ(fidelityOf({}).area_ratio, 1.0);
}

// === Of whole transfers

contact::Patch roundPatch(const TriangleMesh& mesh,
                          const Eigen::Vector3d& root,
                          double radius) {
  contact::Patch patch;
  patch.name = "thumb";
  int v = 0;
  (mesh.vertices().colwise() - root).colwise().norm().minCoeff(&v);
  patch.root = surfacePointAtVertex(mesh, v);
  patch.direction_O = geometry::anyTangentAt(mesh, patch.root);
  const geometry::LogMap map = computeLogMap(mesh, patch.root, *patch.direction_O, 1.1 * radius,
                                             geometry::LogMapMethod::kExact);
  const geometry::LogMapInverse inverse(mesh, map);
  for (int i = 0; i < kCount; ++i) {
    const double phi = 2.0 * kPi * i / kCount;
    patch.interpolation_boundary.push_back(
        inverse.at(radius * Eigen::Vector2d(std::cos(phi), std::sin(phi))).point);
  }
  return patch;
}

/// The transfer of a round patch to a rigid hand whose skin is `skin_mesh`, about `root_S`.
PatchTransfer transferRound(const TriangleMesh& object,
                            const Eigen::Vector3d& root,
                            double radius,
                            const TriangleMesh& skin_mesh,
                            const Eigen::Vector3d& root_S) {
  const auto model = test::makeRigidHand(skin_mesh);
  const hand::Skin skin = test::makeRigidSkin(*model, skin_mesh);
  PatchPlacement placement;
  placement.root_S = skin.locator().nearest(root_S).point;
  placement.direction_S = geometry::anyTangentAt(skin_mesh, placement.root_S);
  return transferPatch(object, roundPatch(object, root, radius), skin, placement);
}

TEST(PatchFidelity, IsPerfectBetweenPlanes) {
  const TriangleMesh plate = test::makePlate(40, 40, 0.001);
  const Fidelity fidelity =
      transferRound(plate, {0, 0, 0}, 0.012, plate, {0.0031, 0.002, 0}).fidelity;
  EXPECT_LT(fidelity.distance_max, 1e-9);
  EXPECT_LT(fidelity.angle_max_rad, 1e-9);
  EXPECT_NEAR(fidelity.area_ratio, 1.0, 1e-9);
  EXPECT_LT(fidelity.projection_max_m, 1e-12);
}

TEST(PatchFidelity, FromAPlaneToACylinderLosesOnlyWhatChordsLose) {
  const TriangleMesh plate = test::makePlate(40, 40, 0.001);
  const double R = 0.01;
  Eigen::Matrix3Xd bent = plate.vertices();
  for (int v = 0; v < plate.vertexCount(); ++v) {
    const double angle = plate.vertex(v).x() / R;
    bent.col(v) << R * std::sin(angle), plate.vertex(v).y(), R * std::cos(angle);
  }
  const double radius = 0.01;
  const Fidelity fidelity =
      transferRound(plate, {0, 0, 0}, radius, TriangleMesh(bent, plate.faces()), {0, 0, R})
          .fidelity;
  // An edge of a quarter of the radius spans at most 0.27 rad, facets included: 1 - sinc / 24.
  const double span = (radius / 4 + 0.001) / R;
  EXPECT_LT(fidelity.distance_max, span * span / 24);
  EXPECT_GT(fidelity.distance_max, 0.0);
  EXPECT_NEAR(fidelity.area_ratio, 1.0, span * span / 24);
}

TEST(PatchFidelity, BetweenSpheresIsThatOfTheirCircles) {
  const double R_O = 0.03;
  const double R_S = 0.02;
  const double r = 0.012;
  const Fidelity fidelity = transferRound(geometry::makeSphere(R_O, 5), {0, 0, R_O}, r,
                                          geometry::makeSphere(R_S, 5), {0, 0, R_S})
                                .fidelity;
  // The same net on round spheres; facets of 1 mm move single knots by some 10 um.
  const Fidelity round = fidelityOf(netOf(r, sphere(R_O), sphere(R_S)));
  EXPECT_NEAR(fidelity.distance_mean, round.distance_mean, 3e-3);
  EXPECT_NEAR(fidelity.distance_max, round.distance_max, 0.02);
  EXPECT_NEAR(fidelity.angle_mean_rad, round.angle_mean_rad, 3e-3);
  const double cap_O = 2 * kPi * R_O * R_O * (1 - std::cos(r / R_O));
  const double cap_S = 2 * kPi * R_S * R_S * (1 - std::cos(r / R_S));
  EXPECT_NEAR(fidelity.area_ratio, cap_S / cap_O, 4e-3);
}

}  // namespace
}  // namespace handgraft::transfer
