#include "core/contact/pose_contacts.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/contact/segmentation.h"

#include "tests/support/plates.h"

namespace handgraft::contact {
namespace {

using geometry::TriangleMesh;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

TriangleMesh ballAt(const Eigen::Vector3d& centre, double radius) {
  return transformed(geometry::makeSphere(radius, 5),
                     Eigen::Affine3d(Eigen::Translation3d(centre)));
}

/// The formula, from the depth of the vertex and of the part.
double contactAt(double depth, double deepest) {
  return std::min(1.0, 1.0 + deepest / 0.010) * std::max(0.0, 1.0 - (deepest - depth) / 0.006);
}

TEST(ContactsFromPose, FallsWithTheDistanceToABall) {
  const TriangleMesh plate = test::makePlate(20, 20, 0.002);
  const Eigen::Vector3d centre(0.004, -0.002, 0.013);  // above a vertex
  const ContactMap map = contactsFromPose(plate, {{"index_tip", ballAt(centre, 0.010)}});
  ASSERT_EQ(map.mesh_O.vertexCount(), plate.vertexCount());
  for (int v = 0; v < plate.vertexCount(); ++v) {
    const double distance = (plate.vertex(v) - centre).norm() - 0.010;
    EXPECT_NEAR(map.value[v], contactAt(-distance, -0.003), 2e-2);
    EXPECT_EQ(map.label[v], map.value[v] > 0.0 ? 0 : -1);
  }
}

TEST(ContactsFromPose, DrawsASunkPartBackToTheSurface) {
  const TriangleMesh plate = test::makePlate(40, 40, 0.001);
  for (const double depth : {0.0, 0.002, 0.005, 0.008}) {
    const ContactMap map = contactsFromPose(
        plate, {{"index", ballAt(Eigen::Vector3d(0, 0, 0.010 - depth), 0.010)}});
    EXPECT_NEAR(map.value.maxCoeff(), 1.0, 1e-6) << depth;
    // A ball that is drawn back touches around one point, as if it had not been sunk.
    const ContactSet set = segment(map, {});
    ASSERT_EQ(set.patches.size(), 1u) << depth;
    double radius = 0.0;
    for (const auto& point : set.patches[0].interpolation_boundary)
      radius += positionOf(map.mesh_O, point).norm() /
                static_cast<double>(set.patches[0].interpolation_boundary.size());
    // Three quarters of contact: where the ball is 1.5 mm less deep than in its middle.
    const double height = 0.010 - depth;
    EXPECT_NEAR(radius, std::sqrt(std::pow(height + 0.0015, 2) - height * height), 7e-4)
        << depth;
  }
}

TEST(ContactsFromPose, GoesByDistanceAloneIfNothingIsSoft) {
  const TriangleMesh plate = test::makePlate(40, 40, 0.002);
  const ContactMap map = contactsFromPose(
      plate, {{"palm", ballAt(Eigen::Vector3d::Zero(), 0.030)}}, {.softness_m = 0.0});
  for (int v = 0; v < plate.vertexCount(); ++v) {
    const double r = plate.vertex(v).norm();
    // The ball is a polyhedron within 0.1 mm of the sphere; there either answer is right.
    if (r < 0.0299) {
      EXPECT_EQ(map.value[v], 1.0);
    } else if (r > 0.030) {
      EXPECT_NEAR(map.value[v], std::max(0.0, 1.0 - (r - 0.030) / 0.010), 2e-3);
    }
  }
}

TEST(ContactsFromPose, TakesLessOfAPartThatHovers) {
  const TriangleMesh plate = test::makePlate(20, 20, 0.002);
  const ContactMap map = contactsFromPose(plate, {{"index", ballAt({0, 0, 0.014}, 0.010)}});
  EXPECT_NEAR(map.value.maxCoeff(), 0.6, 1e-3);
}

TEST(ContactsFromPose, KnowsTheInsideOfAnOpenPart) {
  // A box without its far face, and one whose walls are there twice and cross each other.
  const TriangleMesh box = geometry::makeBox({0.04, 0.04, 0.04});
  int open_face = 0;
  while (box.faceNormals()(2, open_face) < 0.5)
    ++open_face;
  Eigen::Matrix3Xi faces(3, box.faceCount() - 1);
  for (int f = 0, kept = 0; f < box.faceCount(); ++f)
    if (f != open_face) faces.col(kept++) = box.face(f);
  const TriangleMesh open(box.vertices(), faces);
  const TriangleMesh twice = geometry::merged(
      {box, transformed(box, Eigen::Affine3d(Eigen::Translation3d(0.012, 0, 0)))});
  const TriangleMesh plate = test::makePlate(4, 4, 0.002);
  for (const TriangleMesh& part : {open, twice}) {
    const ContactMap map = contactsFromPose(plate, {{"palm", part}}, {.softness_m = 0.0});
    EXPECT_EQ(map.value.minCoeff(), 1.0);
  }
}

TEST(ContactsFromPose, LabelsTheNearerPart) {
  const TriangleMesh plate = test::makePlate(40, 10, 0.002);
  const ContactMap map = contactsFromPose(plate, {{"index", ballAt({-0.008, 0, 0.011}, 0.01)},
                                                  {"empty", TriangleMesh()},
                                                  {"middle", ballAt({0.008, 0, 0.011}, 0.01)}});
  for (int v = 0; v < plate.vertexCount(); ++v) {
    if (map.value[v] == 0.0 || plate.vertex(v).x() == 0.0) continue;
    EXPECT_EQ(map.label[v], plate.vertex(v).x() < 0.0 ? 0 : 2);
  }
  const ContactSet set = segment(map, {});
  ASSERT_EQ(set.patches.size(), 2u);
  EXPECT_EQ(set.patches[0].name, "index");
  EXPECT_EQ(set.patches[1].name, "middle");
}

TEST(ContactsFromPose, GivesPatchesAShapeOnAMeshOfTwelveFaces) {
  const TriangleMesh box = geometry::makeBox({0.16, 0.05, 0.21});
  const ContactMap map = contactsFromPose(box, {{"thumb", ballAt({0.01, 0.034, 0.02}, 0.008)}});
  const ContactSet set = segment(map, {});
  ASSERT_EQ(set.patches.size(), 1u);
  // A ball 1 mm off the face: three quarters of contact are where it is 1.5 mm farther off.
  const double radius = std::sqrt(0.0105 * 0.0105 - 0.009 * 0.009);
  for (const auto& point : set.patches[0].interpolation_boundary) {
    const Eigen::Vector3d p = positionOf(map.mesh_O, point);
    EXPECT_NEAR((p - Eigen::Vector3d(0.01, 0.025, 0.02)).norm(), radius, 0.004);
  }
}

TEST(ContactsFromPose, SaysHowFarAHandIsThatTouchesNothing) {
  const TriangleMesh plate = test::makePlate(4, 4, 0.002);
  EXPECT_THAT(
      [&] {
        contactsFromPose(plate, {{"index", ballAt({0, 0, 0.5}, 0.01)}});
      },
      ThrowsMessage<InvalidInput>(HasSubstr("nearest part is 490 mm")));
}

TEST(ContactsFromPose, RefusesWhatCannotBeMeant) {
  const TriangleMesh plate = test::makePlate(4, 4, 0.002);
  const std::vector<PosedSurface> hand = {{"index", ballAt({0, 0, 0.01}, 0.01)}};
  EXPECT_THROW(contactsFromPose(TriangleMesh(), hand), InvalidInput);
  EXPECT_THROW(contactsFromPose(plate, {}), InvalidInput);
  for (const double bad : {0.0, -0.01, std::numeric_limits<double>::quiet_NaN(),
                           std::numeric_limits<double>::infinity()}) {
    EXPECT_THROW(contactsFromPose(plate, hand, {.reach_m = bad}), InvalidInput) << bad;
  }
  EXPECT_THROW(contactsFromPose(plate, hand, {.softness_m = -0.001}), InvalidInput);
  EXPECT_THROW(contactsFromPose(plate, hand, {.longest_edge_m = 0.0}), InvalidInput);
}

}  // namespace
}  // namespace handgraft::contact
