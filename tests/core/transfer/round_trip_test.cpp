// There and back again between smooth surfaces. The way back goes over other triangulations of
// both surfaces, so that it shares nothing with the way there but the surfaces themselves.
#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include <gtest/gtest.h>

#include "core/geometry/log_map.h"
#include "core/transfer/patch_transfer.h"

#include "tests/support/plate_hand.h"

namespace handgraft::transfer {
namespace {

using contact::Patch;
using geometry::LogMapMethod;
using geometry::SurfacePoint;
using geometry::TriangleMesh;

constexpr double kPi = std::numbers::pi;
constexpr double kMostMean = 1e-4;  // m

/// An ellipsoid, its icosphere turned by `angle` first: another triangulation of one surface.
TriangleMesh ellipsoid(const Eigen::Vector3d& semiaxes_m, int subdivisions, double angle) {
  const Eigen::Vector3d axis = Eigen::Vector3d(0.3, -0.8, 0.5).normalized();
  const Eigen::Affine3d X =
      Eigen::Scaling(semiaxes_m) * Eigen::Affine3d(Eigen::AngleAxisd(angle, axis));
  return transformed(geometry::makeSphere(1.0, subdivisions), X);
}

/// A torus of quadrilaterals cut in two, slanted by `slant` columns a turn of the tube: smooth,
/// and a saddle on its inside.
TriangleMesh torus(double radius_m, double tube_m, int around, int along, double slant) {
  Eigen::Matrix3Xd vertices(3, around * along);
  Eigen::Matrix3Xi faces(3, 2 * around * along);
  for (int j = 0; j < along; ++j) {
    for (int i = 0; i < around; ++i) {
      const double v = 2.0 * kPi * i / around;
      const double u = 2.0 * kPi * (j + slant * std::sin(v)) / along;
      const double out = radius_m + tube_m * std::cos(v);
      vertices.col(j * around + i) << out * std::cos(u), out * std::sin(u),
          tube_m * std::sin(v);
      const int a = j * around + i;
      const int b = j * around + (i + 1) % around;
      const int c = (j + 1) % along * around + (i + 1) % around;
      const int d = (j + 1) % along * around + i;
      faces.col(2 * a) << a, c, b;
      faces.col(2 * a + 1) << a, d, c;
    }
  }
  return {vertices, faces};
}

/// A surface as object and as hand, ready for questions.
struct Surface {
  explicit Surface(TriangleMesh triangulation)
      : mesh(std::move(triangulation)),
        hand(test::makeRigidHand(mesh)),
        skin(test::makeRigidSkin(*hand, mesh)) {}

  [[nodiscard]] SurfacePoint nearest(const Eigen::Vector3d& p) const {
    return skin.locator().nearest(p).point;
  }

  TriangleMesh mesh;
  std::shared_ptr<const hand::HandModel> hand;
  hand::Skin skin;
};

struct Pair {
  std::string name;
  std::shared_ptr<const Surface> there;
  std::shared_ptr<const Surface> back;
};

Pair pairOf(const std::string& name, TriangleMesh there, TriangleMesh back) {
  return {name, std::make_shared<const Surface>(std::move(there)),
          std::make_shared<const Surface>(std::move(back))};
}

const std::vector<Pair>& pairs() {
  static const std::vector<Pair> all = {
      pairOf("sphere", ellipsoid({0.035, 0.035, 0.035}, 5, 0.0),
             ellipsoid({0.035, 0.035, 0.035}, 5, 1.1)),
      pairOf("ellipsoid", ellipsoid({0.03, 0.04, 0.07}, 5, 0.0),
             ellipsoid({0.03, 0.04, 0.07}, 5, 0.7)),
      pairOf("torus", torus(0.06, 0.025, 120, 300, 0.0), torus(0.06, 0.025, 150, 260, 6.0))};
  return all;
}

/// A lopsided loop: no symmetry hides a wrong turn or mirror.
Patch patchOn(const TriangleMesh& mesh, const SurfacePoint& root, double radius_m) {
  Patch patch;
  patch.name = "patch";
  patch.root = root;
  patch.direction_O = normalOf(mesh, root).unitOrthogonal();
  const geometry::LogMap map =
      computeLogMap(mesh, root, *patch.direction_O, 1.2 * radius_m, LogMapMethod::kExact);
  const geometry::LogMapInverse inverse(mesh, map);
  for (int i = 0; i < contact::kDefaultInterpolationCount; ++i) {
    const double angle = 2.0 * kPi * i / contact::kDefaultInterpolationCount;
    const double r = radius_m * (0.75 + 0.25 * std::cos(angle) * std::sin(angle + 0.4));
    const auto place = inverse.at(r * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
    EXPECT_TRUE(place.point.valid());
    if (place.point.valid()) patch.interpolation_boundary.push_back(place.point);
  }
  return patch;
}

/// How far the points of a patch are from where they were, on average; `turn` puts the hand's
/// direction on the way back off by that angle.
double meanError(const Pair& object,
                 const Pair& skin,
                 const Patch& patch,
                 const SurfacePoint& root_S,
                 LogMapMethod method,
                 double turn = 0.0) {
  TransferOptions options;
  options.method = method;
  const Eigen::Vector3d normal_S = normalOf(skin.there->mesh, root_S);
  const Eigen::Vector3d direction_S = normal_S.unitOrthogonal();
  const PatchTransfer there = transferPatch(object.there->mesh, patch, skin.there->skin,
                                            {root_S, direction_S}, options);
  EXPECT_TRUE(there.lost.empty());

  Patch landed;
  landed.name = patch.name;
  landed.root = skin.back->nearest(positionOf(skin.there->mesh, root_S));
  landed.direction_O = Eigen::AngleAxisd(turn, normal_S) * direction_S;
  for (const Eigen::Vector3d& p : there.points_S)
    landed.interpolation_boundary.push_back(skin.back->nearest(p));
  const SurfacePoint home = object.back->nearest(positionOf(object.there->mesh, patch.root));
  const PatchTransfer back = transferPatch(skin.back->mesh, landed, object.back->skin,
                                           {home, *patch.direction_O}, options);
  EXPECT_TRUE(back.lost.empty());
  EXPECT_EQ(back.points_S.size(), patch.interpolation_boundary.size());
  if (back.points_S.size() != patch.interpolation_boundary.size()) return 1.0;
  double sum = 0.0;
  for (std::size_t i = 0; i < back.points_S.size(); ++i) {
    const Eigen::Vector3d p_O = positionOf(object.there->mesh, patch.interpolation_boundary[i]);
    sum += (back.points_S[i] - p_O).norm();
  }
  return sum / static_cast<double>(back.points_S.size());
}

/// Spread over the mesh, inside faces.
SurfacePoint rootOn(const TriangleMesh& mesh, int number) {
  return {static_cast<int>((2654435761U * static_cast<unsigned>(number + 1)) %
                           static_cast<unsigned>(mesh.faceCount())),
          {0.2, 0.5, 0.3}};
}

class RoundTrip : public ::testing::TestWithParam<LogMapMethod> {};

TEST_P(RoundTrip, EndsWhereItBeganOnSmoothSurfaces) {
  for (const Pair& object : pairs()) {
    for (const Pair& skin : pairs()) {
      if (object.name == skin.name) continue;
      double sum = 0.0;
      int count = 0;
      double worst = 0.0;
      for (const double radius_m : {0.005, 0.010, 0.020}) {
        for (int i = 0; i < 3; ++i) {
          const Patch patch =
              patchOn(object.there->mesh, rootOn(object.there->mesh, i), radius_m);
          const double error =
              meanError(object, skin, patch, rootOn(skin.there->mesh, 7 * i + 2), GetParam());
          sum += error;
          worst = std::max(worst, error);
          ++count;
        }
      }
      EXPECT_LE(sum / count, kMostMean) << object.name << " by way of " << skin.name;
      RecordProperty((object.name + "_" + skin.name + "_mean_um").c_str(),
                     std::to_string(1e6 * sum / count));
      RecordProperty((object.name + "_" + skin.name + "_worst_patch_um").c_str(),
                     std::to_string(1e6 * worst));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Methods,
                         RoundTrip,
                         ::testing::Values(LogMapMethod::kFast,
                                           LogMapMethod::kExact,
                                           LogMapMethod::kAuto),
                         [](const auto& method) {
                           return std::string(nameOf(method.param));
                         });

// Factors all four meshes: one patch has to do.
TEST(RoundTripOnce, EndsWhereItBeganBySmooth) {
  const Pair& object = pairs()[0];
  const Pair& skin = pairs()[1];
  const Patch patch = patchOn(object.there->mesh, rootOn(object.there->mesh, 1), 0.015);
  EXPECT_LE(meanError(object, skin, patch, rootOn(skin.there->mesh, 3), LogMapMethod::kSmooth),
            kMostMean);
}

// The judge itself.
TEST(RoundTripJudge, SeesATurnOfADegree) {
  const Pair& object = pairs()[0];
  const Pair& skin = pairs()[1];
  const Patch patch = patchOn(object.there->mesh, rootOn(object.there->mesh, 0), 0.020);
  const SurfacePoint root_S = rootOn(skin.there->mesh, 2);
  EXPECT_GT(meanError(object, skin, patch, root_S, LogMapMethod::kExact, kPi / 180.0),
            2.0 * kMostMean);
}

}  // namespace
}  // namespace handgraft::transfer
