#include "core/contact/patch.h"

#include <cmath>
#include <limits>
#include <numeric>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"

#include "tests/support/plates.h"

namespace handgraft::contact {
namespace {

using geometry::positionOf;
using geometry::TriangleMesh;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

constexpr double kStep = 0.01;

/// The 4 x 4 plate's middle square of 2 x 2 cells, counter-clockwise seen from +z.
const std::vector<int> square_outline = {6, 7, 8, 13, 18, 17, 16, 11};

Patch squarePatch(const TriangleMesh& mesh) {
  Patch patch;
  patch.name = "thumb";
  patch.root = geometry::surfacePointAtVertex(mesh, 12);
  patch.direction_O = Eigen::Vector3d::UnitX();
  patch.boundary = square_outline;
  patch.interpolation_boundary = sampleLoop(mesh, square_outline);
  return patch;
}

TEST(SampleLoop, PlacesPointsAtEqualArcLengthOnASquare) {
  const TriangleMesh mesh = test::makePlate(4, 4, kStep);
  const auto points = sampleLoop(mesh, square_outline, 32);
  ASSERT_EQ(points.size(), 32u);
  for (int k = 0; k < 32; ++k) {
    const double s = 8 * kStep * k / 32;  // along the square from (-step, -step)
    const double side = 2 * kStep;
    Eigen::Vector3d expected(-kStep, -kStep, 0.0);
    expected.x() += std::clamp(s, 0.0, side) - std::clamp(s - 2 * side, 0.0, side);
    expected.y() += std::clamp(s - side, 0.0, side) - std::clamp(s - 3 * side, 0.0, side);
    EXPECT_LT((positionOf(mesh, points[k]) - expected).norm(), 1e-15) << k;
  }
}

TEST(SampleLoop, GivesWholeWeightsOnTheMesh) {
  const TriangleMesh mesh = test::makePlate(4, 4, kStep);
  for (const int count : {3, 7, 25, 1000}) {
    for (const auto& point : sampleLoop(mesh, square_outline, count)) {
      EXPECT_NO_THROW(geometry::validate(mesh, point, "sample"));
    }
  }
}

TEST(SampleLoop, WalksAlongTheEdgeOfASurface) {
  const TriangleMesh mesh = test::makePlate(1, 1, kStep);
  const auto points = sampleLoop(mesh, {0, 2, 3, 1}, 4);  // clockwise: against the halfedges
  for (int k = 0; k < 4; ++k) {
    const int expected[] = {0, 2, 3, 1};
    EXPECT_LT((positionOf(mesh, points[k]) - mesh.vertex(expected[k])).norm(), 1e-15);
  }
}

TEST(SampleLoop, NamesNeighboursWithoutEdge) {
  const TriangleMesh mesh = test::makePlate(4, 4, kStep);
  EXPECT_THAT(
      [&] {
        sampleLoop(mesh, {6, 8, 18});
      },
      ThrowsMessage<InvalidInput>(HasSubstr("6 and 8")));
}

TEST(SampleLoop, RefusesVerticesThatDoNotExistShortLoopsAndCounts) {
  const TriangleMesh mesh = test::makePlate(4, 4, kStep);
  EXPECT_THROW(sampleLoop(mesh, {6, 7, 25}), InvalidInput);
  EXPECT_THROW(sampleLoop(mesh, {6, 7, -1}), InvalidInput);
  EXPECT_THROW(sampleLoop(mesh, {6, 7}), InvalidInput);
  EXPECT_THROW(sampleLoop(mesh, {}), InvalidInput);
  EXPECT_THROW(sampleLoop(mesh, square_outline, 2), InvalidInput);
  EXPECT_THROW(sampleLoop(mesh, square_outline, std::numeric_limits<int>::max()), InvalidInput);
}

TEST(Patch, ThatIsSoundPasses) {
  const TriangleMesh mesh = test::makePlate(4, 4, kStep);
  EXPECT_NO_THROW(validate(mesh, squarePatch(mesh)));
}

TEST(Patch, FaultsAreNamedWithThePatch) {
  const TriangleMesh mesh = test::makePlate(4, 4, kStep);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto refuses = [&](const char* text, auto spoil) {
    Patch patch = squarePatch(mesh);
    spoil(patch);
    EXPECT_THAT(
        [&] {
          validate(mesh, patch);
        },
        ThrowsMessage<InvalidInput>(::testing::AllOf(HasSubstr("'thumb'"), HasSubstr(text))));
  };
  refuses("parallel", [](Patch& p) {
    p.direction_O = Eigen::Vector3d(0, 0, -2);
  });
  refuses("direction", [&](Patch& p) {
    p.direction_O = Eigen::Vector3d(nan, 0, 0);
  });
  refuses("direction", [](Patch& p) {
    p.direction_O = Eigen::Vector3d::Zero();
  });
  refuses("root", [](Patch& p) {
    p.root.face = 99;
  });
  refuses("7 twice", [](Patch& p) {
    p.boundary = {6, 7, 8, 7};
  });
  refuses("weight is -1", [](Patch& p) {
    p.weight = -1.0;
  });
  refuses("weight is nan", [&](Patch& p) {
    p.weight = nan;
  });
  refuses("2 points", [](Patch& p) {
    p.interpolation_boundary.resize(2);
  });
}

TEST(Patch, WithoutANameIsRefused) {
  const TriangleMesh mesh = test::makePlate(4, 4, kStep);
  Patch patch = squarePatch(mesh);
  patch.name.clear();
  EXPECT_THROW(validate(mesh, patch), InvalidInput);
}

}  // namespace
}  // namespace handgraft::contact
