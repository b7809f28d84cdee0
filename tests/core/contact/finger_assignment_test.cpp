#include "core/contact/finger_assignment.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/contact/segmentation.h"

#include "tests/support/plates.h"

namespace handgraft::contact {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

constexpr double kAbove = 0.008;  ///< bones over the plate

/// A flat hand over a plate: fingers along +y, 20 mm apart, the thumb at -40 mm.
HandJoints flatHand() {
  HandJoints joints;
  joints.p_O.col(0) << 0.0, -0.08, kAbove;
  for (int finger = 0; finger < 5; ++finger) {
    for (int i = 0; i < 4; ++i) {
      joints.p_O.col(1 + 4 * finger + i) << 0.02 * (finger - 2), -0.02 + 0.02 * i, kAbove;
    }
  }
  return joints;
}

ContactMap emptyMap() {
  ContactMap map;
  map.mesh_O = test::makePlate(120, 160, 0.001);
  map.value = Eigen::VectorXd::Zero(map.mesh_O.vertexCount());
  return map;
}

void touchBox(ContactMap& map, double x0, double x1, double y0, double y1) {
  for (int v = 0; v < map.mesh_O.vertexCount(); ++v) {
    const Eigen::Vector3d p = map.mesh_O.vertex(v);
    if (p.x() > x0 && p.x() < x1 && p.y() > y0 && p.y() < y1) map.value[v] = 1.0;
  }
}

std::vector<std::string> namesOf(const ContactSet& set) {
  std::vector<std::string> names;
  for (const Patch& patch : set.patches)
    names.push_back(patch.name);
  return names;
}

SegmentationOptions withJoints() {
  SegmentationOptions options;
  options.joints_O = flatHand();
  return options;
}

TEST(NearestBone, FindsThePartAndTheWayToTheWrist) {
  const NearestBone finger = nearestBone(flatHand(), {0.003, 0.01, 0.0});
  EXPECT_EQ(finger.part, 2);
  EXPECT_NEAR(finger.distance_m, std::hypot(0.003, kAbove), 1e-12);
  EXPECT_TRUE(finger.towards_wrist_O.isApprox(-Eigen::Vector3d::UnitY()));
  EXPECT_EQ(nearestBone(flatHand(), {0.0, -0.06, 0.0}).part, kPalm);
  EXPECT_NEAR(nearestBone(flatHand(), {0.003, 0.01, 0.0}, 4).distance_m,
              std::hypot(0.037, kAbove), 1e-12);
}

/// The hand on the other side of the plate's middle line, 0.11 m up its x axis.
HandJoints otherHand() {
  HandJoints joints = flatHand();
  joints.p_O.row(0) = (0.11 - joints.p_O.row(0).array()).matrix();
  return joints;
}

// Shows 7: two hands on one object.
TEST(OwnContact, LeavesWhatAnotherHandTouchedToIt) {
  ContactMap map;
  map.mesh_O = test::makePlate(400, 160, 0.001);
  map.value = Eigen::VectorXd::Zero(map.mesh_O.vertexCount());
  touchBox(map, -0.005, 0.005, 0.01, 0.03);  // our middle finger
  touchBox(map, 0.106, 0.116, 0.01, 0.03);   // the other one's, 66 mm from our little finger
  touchBox(map, 0.062, 0.068, 0.01, 0.03);   // the other one's little finger, 25 mm from ours
  SegmentationOptions options;
  options.joints_O = flatHand();
  const ContactSet alone = segment(map, options);
  EXPECT_THAT(namesOf(alone),
              ElementsAre("middle_middle", "middle_distal", "little_middle", "little_distal"))
      << "without the other hand's joints the nearer one passes for ours";
  EXPECT_THAT(alone.notes, Contains(HasSubstr("farther than 40 mm from the hand's joints, left "
                                              "out: 1")));

  options.other_joints_O = {otherHand()};
  const ContactSet own = segment(map, options);
  EXPECT_THAT(namesOf(own), ElementsAre("middle_middle", "middle_distal"));
  EXPECT_THAT(own.notes, Contains(HasSubstr("nearer to another hand's joints, left out: 2")));

  options.joints_O = otherHand();
  options.other_joints_O = {flatHand()};
  EXPECT_THAT(namesOf(segment(map, options)),
              ElementsAre("middle_middle", "middle_distal", "little_middle", "little_distal"));
}

TEST(OwnContact, RefusesJointsOfAnotherObject) {
  ContactMap map = emptyMap();
  touchBox(map, -0.005, 0.005, 0.01, 0.03);
  SegmentationOptions options = withJoints();
  options.joints_O->p_O.row(2).array() += 0.2;
  EXPECT_THAT(
      [&] {
        segment(map, options);
      },
      ThrowsMessage<InvalidInput>(HasSubstr("208 mm from their bones; permitted are 40 mm")));
}

TEST(AssignFingers, NamesPatchesByTheNearestFinger) {
  ContactMap map = emptyMap();
  touchBox(map, -0.045, -0.035, 0.02, 0.04);
  touchBox(map, 0.016, 0.025, 0.02, 0.04);
  touchBox(map, -0.006, 0.006, -0.07, -0.05);
  const ContactSet set = segment(map, withJoints());
  EXPECT_THAT(namesOf(set), ElementsAre("thumb_distal", "ring_distal", "palm"));
}

TEST(AssignFingers, SplitsARegionThatTwoFingersTouch) {
  ContactMap map = emptyMap();
  touchBox(map, -0.006, 0.026, 0.02, 0.035);  // under middle (x = 0) and ring (x = 20 mm)
  const ContactSet set = segment(map, withJoints());
  ASSERT_THAT(namesOf(set), ElementsAre("middle_distal", "ring_distal"));
  for (const int v : set.patches[0].boundary)
    EXPECT_LE(map.mesh_O.vertex(v).x(), 0.0105);
  for (const int v : set.patches[1].boundary)
    EXPECT_GE(map.mesh_O.vertex(v).x(), 0.0095);
}

TEST(AssignFingers, CutsNoSliverFromAPatch) {
  // 3 of 24 mm lie nearer to the ring finger.
  ContactMap map = emptyMap();
  touchBox(map, -0.011, 0.013, 0.02, 0.04);
  EXPECT_THAT(namesOf(segment(map, withJoints())), ElementsAre("middle_distal"));
}

TEST(AssignFingers, SplitsAFingersRegionByItsSegments) {
  ContactMap map = emptyMap();
  touchBox(map, -0.005, 0.005, 0.0, 0.04);
  const ContactSet set = segment(map, withJoints());
  ASSERT_THAT(namesOf(set), ElementsAre("middle_middle", "middle_distal"));
  for (const int v : set.patches[0].boundary)
    EXPECT_LE(map.mesh_O.vertex(v).y(), 0.0205);
  for (const Patch& patch : set.patches) {
    ASSERT_TRUE(patch.place.has_value()) << patch.name;
    EXPECT_EQ(patch.place->digit, "middle");
    EXPECT_NEAR(patch.place->along, 0.5, 0.06);
  }
  EXPECT_NEAR(set.patches[1].place->from_tip, 1.0 / 6.0, 0.03);
}

/// The flat hand lies on the plate, fingers bent a little towards it: palmar sides down, which
/// is what the plate's normal faces.
TEST(PlaceByJoints, TellsTheSideOfAFingerThatTouches) {
  HandJoints joints = flatHand();
  for (int finger = 1; finger < 5; ++finger)
    joints.p_O(2, 4 + 4 * finger) -= 0.001;
  const Eigen::Vector3d root(0.0, 0.01, 0.0);
  const auto palmar = placeByJoints(joints, "middle_middle", root, Eigen::Vector3d::UnitZ());
  ASSERT_TRUE(palmar.has_value());
  EXPECT_NEAR(palmar->around_rad, 0.0, 0.05);
  // What looks to +x is touched by a finger's side that looks to -x, the thumb's.
  const auto side = placeByJoints(joints, "middle_middle", root, Eigen::Vector3d::UnitX());
  EXPECT_NEAR(side->around_rad, 0.5 * 3.14159265358979323846, 0.05);
  const auto palm = placeByJoints(joints, "palm", {0.01, -0.05, 0.0}, Eigen::Vector3d::UnitZ());
  ASSERT_TRUE(palm.has_value());
  EXPECT_NEAR(palm->along, 0.5, 0.1);
  EXPECT_NEAR(palm->across, 0.5, 0.1);
  EXPECT_NEAR(palm->around_rad, 0.0, 0.05);
  EXPECT_FALSE(placeByJoints(joints, "c1", root, Eigen::Vector3d::UnitZ()).has_value());
}

TEST(AssignFingers, LeavesLabelsThatNameFingersAlone) {
  ContactMap map = emptyMap();
  touchBox(map, -0.005, 0.005, 0.02, 0.04);
  map.label.assign(static_cast<std::size_t>(map.mesh_O.vertexCount()), 0);
  map.segment_names = {"little_tip"};
  EXPECT_THAT(namesOf(segment(map, withJoints())), ElementsAre("little_distal"));
  map.segment_names = {"segment"};
  EXPECT_THAT(namesOf(segment(map, withJoints())), ElementsAre("middle_distal"));
}

TEST(AssignFingers, RefusesJointsThatAreNone) {
  ContactMap map = emptyMap();
  touchBox(map, -0.005, 0.005, 0.02, 0.04);
  SegmentationOptions options = withJoints();
  options.joints_O->p_O(1, 6) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(
      [&] {
        segment(map, options);
      },
      ThrowsMessage<InvalidInput>(HasSubstr("joint 6 is not finite")));
  options.joints_O->p_O.setZero();
  EXPECT_THROW(segment(map, options), InvalidInput);
}

TEST(DirectionTowardsWrist, RunsAlongTheFingerInTheTangentPlane) {
  ContactMap map = emptyMap();
  touchBox(map, -0.005, 0.005, 0.02, 0.04);
  const ContactSet set = segment(map, withJoints());
  ASSERT_TRUE(set.patches.at(0).direction_O.has_value());
  EXPECT_TRUE(set.patches[0].direction_O->isApprox(-Eigen::Vector3d::UnitY(), 1e-9));
}

TEST(DirectionTowardsWrist, TakesTheWristWhereTheBoneStandsOnTheSurface) {
  const Eigen::Vector3d p(0.0, 0.05, 0.0);
  HandJoints joints = flatHand();
  EXPECT_FALSE(directionTowardsWrist(joints, "middle", p, Eigen::Vector3d::UnitY()));
  joints.p_O.col(0) << 0.1, 0.05, 0.0;
  const auto direction = directionTowardsWrist(joints, "middle", p, Eigen::Vector3d::UnitY());
  ASSERT_TRUE(direction.has_value());
  EXPECT_TRUE(direction->isApprox(Eigen::Vector3d::UnitX(), 1e-9));
}

}  // namespace
}  // namespace handgraft::contact
