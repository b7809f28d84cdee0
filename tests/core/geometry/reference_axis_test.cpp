#include "core/geometry/reference_axis.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/geometry/log_mapper.h"
#include "core/geometry/tangent.h"

#include "tests/support/plates.h"

namespace handgraft::geometry {
namespace {

constexpr double kRadius = 0.012;

/// Largest distance between the coordinates made with `direction` and those made with the
/// reference axis, turned.
double difference(const TriangleMesh& mesh,
                  const SurfacePoint& source,
                  const Eigen::Vector3d& direction,
                  LogMapMethod method) {
  const auto maps = LogMapper::borrowing(mesh);
  const ReferenceAxis axis = referenceAxis(mesh, source, direction);
  const LogMap wanted = maps->map(source, direction, kRadius, method);
  const LogMap reference = maps->map(source, axis.direction, kRadius, method);
  EXPECT_EQ(wanted.vertices.size(), reference.vertices.size());
  double worst = 0.0;
  for (const int v : wanted.vertices) {
    const Eigen::Vector2d expected = logCoordinatesAtVertex(wanted, v);
    const Eigen::Vector2d turned =
        Eigen::Rotation2Dd(-axis.angle) * logCoordinatesAtVertex(reference, v);
    worst = std::max(worst, (turned - expected).norm());
  }
  return worst;
}

class ReferenceAxisOfMethod : public ::testing::TestWithParam<LogMapMethod> {};

TEST_P(ReferenceAxisOfMethod, MakesEveryDirectionARotationOfOneMap) {
  const TriangleMesh ball = makeSphere(0.03, 4);
  const SurfacePoint at_five_fold_vertex = surfacePointAtVertex(ball, 0);
  const SurfacePoint at_vertex = surfacePointAtVertex(ball, 700);
  const SurfacePoint in_face{17, {0.5, 0.2, 0.3}};
  const SurfacePoint on_edge{17, {0.0, 0.4, 0.6}};
  for (const SurfacePoint& source : {at_five_fold_vertex, at_vertex, in_face, on_edge}) {
    for (const double angle : {0.0, 0.4, 2.0, -3.0}) {
      const Eigen::Vector3d direction =
          tangentTurned(ball, source, anyTangentAt(ball, source), angle);
      EXPECT_LT(difference(ball, source, direction, GetParam()), 1e-12) << angle;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(AllMethods,
                         ReferenceAxisOfMethod,
                         ::testing::Values(LogMapMethod::kFast,
                                           LogMapMethod::kExact,
                                           LogMapMethod::kAuto,
                                           LogMapMethod::kSmooth,
                                           LogMapMethod::kHeat),
                         [](const auto& method) {
                           return std::string(nameOf(method.param));
                         });

TEST(ReferenceAxis, ServesSourcesOnTheSurfacesEdgeToo) {
  const TriangleMesh plate = test::makePlate(12, 12, 0.002);
  const SurfacePoint corner = surfacePointAtVertex(plate, 0);
  const SurfacePoint side = surfacePointAtVertex(plate, 6);
  for (const SurfacePoint& source : {corner, side}) {
    // The second points off the plate.
    for (const Eigen::Vector3d& direction : {Eigen::Vector3d(1, 2, 0), {-1, -0.5, 0}}) {
      EXPECT_LT(difference(plate, source, direction, LogMapMethod::kFast), 1e-12);
    }
  }
}

TEST(ReferenceAxis, DependsOnThePlaceAlone) {
  const TriangleMesh ball = makeSphere(0.03, 3);
  for (const SurfacePoint& source :
       {surfacePointAtVertex(ball, 50), SurfacePoint{3, {0.2, 0.7, 0.1}}}) {
    const Eigen::Vector3d x = anyTangentAt(ball, source);
    const ReferenceAxis a = referenceAxis(ball, source, x);
    const ReferenceAxis b = referenceAxis(ball, source, tangentTurned(ball, source, x, 1.3));
    EXPECT_EQ(a.direction, b.direction);
    EXPECT_NEAR(std::remainder(b.angle - a.angle - 1.3, 2 * std::numbers::pi), 0.0,
                1e-2);  // facets
  }
}

TEST(ReferenceAxis, IsTheDirectionItselfWhereFansTurnDifferently) {
  // Two pyramids' tips meet in one vertex; one is steeper, so a turn is rescaled otherwise.
  Eigen::Matrix3Xd vertices(3, 9);
  vertices.col(0).setZero();
  for (int k = 0; k < 4; ++k) {
    const double angle = k * std::numbers::pi / 2.0;
    vertices.col(1 + k) << std::cos(angle), std::sin(angle), -0.2;
    vertices.col(5 + k) << std::cos(angle + 0.3), std::sin(angle + 0.3), -1.5;
  }
  Eigen::Matrix3Xi faces(3, 8);
  for (int k = 0; k < 4; ++k) {
    faces.col(k) << 0, 1 + k, 1 + (k + 1) % 4;
    faces.col(4 + k) << 0, 5 + k, 5 + (k + 1) % 4;
  }
  const TriangleMesh pinched(vertices, faces);
  const Eigen::Vector3d wanted(0.8, 0.33, 0.0);
  const ReferenceAxis axis = referenceAxis(pinched, surfacePointAtVertex(pinched, 0), wanted);
  EXPECT_EQ(axis.direction, wanted);
  EXPECT_EQ(axis.angle, 0.0);
}

TEST(ReferenceAxis, RefusesADirectionAlongTheNormal) {
  const TriangleMesh plate = test::makePlate(4, 4, 0.002);
  EXPECT_THROW(referenceAxis(plate, {5, {0.2, 0.3, 0.5}}, Eigen::Vector3d::UnitZ()),
               InvalidInput);
}

TEST(LogMapper, GivesWhatTheFunctionGivesByEveryMethod) {
  const TriangleMesh ball = makeSphere(0.03, 3);
  const LogMapper maps(std::make_shared<const TriangleMesh>(ball));
  const SurfacePoint source{17, {0.5, 0.2, 0.3}};
  for (const LogMapMethod method :
       {LogMapMethod::kFast, LogMapMethod::kExact, LogMapMethod::kAuto, LogMapMethod::kSmooth,
        LogMapMethod::kHeat}) {
    const LogMap kept = maps.map(source, anyTangentAt(ball, source), kRadius, method);
    const LogMap once =
        computeLogMap(ball, source, anyTangentAt(ball, source), kRadius, method);
    ASSERT_EQ(kept.vertices, once.vertices);
    for (const int v : kept.vertices) {
      EXPECT_EQ(logCoordinatesAtVertex(kept, v), logCoordinatesAtVertex(once, v));
    }
    EXPECT_EQ(kept.method, once.method);
    EXPECT_THROW((void)maps.map(source, Eigen::Vector3d::UnitX(), -1.0, method), InvalidInput);
  }
}

}  // namespace
}  // namespace handgraft::geometry
