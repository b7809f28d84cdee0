// Joints of somebody's pose, by name.
#include "server/handlers/named_joints.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/hand/hand_model.h"

namespace handgraft::server {
namespace {

using testing::HasSubstr;

hand::Joint jointNamed(const std::string& name,
                       hand::JointType type,
                       const std::string& child) {
  hand::Joint joint;
  joint.name = name;
  joint.type = type;
  joint.parent_link = "palm";
  joint.child_link = child;
  joint.lower = -0.5;
  joint.upper = 0.5;
  return joint;
}

hand::HandModel threeJoints() {
  std::vector<hand::Link> links(4);
  const char* const names[] = {"palm", "a", "b", "c"};
  for (std::size_t i = 0; i < links.size(); ++i)
    links[i].name = names[i];
  return hand::HandModel("hand", links,
                         {jointNamed("first", hand::JointType::kRevolute, "a"),
                          jointNamed("second", hand::JointType::kRevolute, "b"),
                          jointNamed("slide", hand::JointType::kPrismatic, "c")});
}

hand::HandPose poseOf(double first, double second, double slide) {
  hand::HandPose pose;
  pose.q = Eigen::Vector3d(first, second, slide);
  return pose;
}

TEST(BeyondLimits, SaysNothingOfWhatIsWithin) {
  EXPECT_TRUE(beyondLimits(threeJoints(), {poseOf(0.5, -0.5, 0.0)}).empty());
}

TEST(BeyondLimits, NamesTheFarthestAndTheOthersInOneLine) {
  const auto notes =
      beyondLimits(threeJoints(), {poseOf(0.6, 0.0, 0.51), poseOf(0.55, -0.9, 0.0)});
  ASSERT_EQ(notes.size(), 1U);
  EXPECT_THAT(notes[0], HasSubstr("joint 'second': -0.9 is beyond its limits -0.5 to 0.5; "
                                  "taken as it is; so are 'first', 'slide'"));
}

TEST(BeyondLimits, TakesTurnsForDegreesButNoSlidersWay) {
  EXPECT_THAT(beyondLimits(threeJoints(), {poseOf(30.0, 0.0, 0.0)}).at(0),
              HasSubstr("angles are radians, not degrees"));
  EXPECT_THAT(beyondLimits(threeJoints(), {poseOf(0.0, 0.0, 30.0)}).at(0),
              Not(HasSubstr("degrees")));
}

}  // namespace
}  // namespace handgraft::server
