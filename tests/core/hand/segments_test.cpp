// Segments of digits whose joints are not one hinge a bone.
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/hand/anatomy.h"
#include "core/hand/kinematics.h"
#include "core/hand/skin.h"

#include "tests/core/hand/urdf_text.h"

namespace handgraft::hand {
namespace {

/// Links of a digit from the palm outwards: their names, and their bones' lengths, m; 0 is a
/// link without a surface, 10 mm from the next joint.
struct Bone {
  std::string name;
  double length = 0.0;
};

/// A digit to +z that closes to +x, from (0, y, 0).
std::string chain(const std::string& digit, double y, const std::vector<Bone>& bones) {
  std::string urdf;
  std::string parent = "palm";
  std::string origin = fmt::format("0 {} 0", y);
  for (const Bone& bone : bones) {
    const std::string link = digit + "_" + bone.name;
    urdf += fmt::format("<link name='{}'>", link);
    if (bone.length > 0.0)
      urdf += fmt::format(
          "<visual><origin xyz='0 0 {}'/><geometry><box size='0.012 0.012 {}'/></geometry>"
          "</visual>",
          0.5 * bone.length, bone.length);
    urdf += fmt::format(
        "</link><joint name='{}_joint' type='revolute'><parent link='{}'/><child link='{}'/>"
        "<origin xyz='{}'/><axis xyz='0 1 0'/><limit lower='0' upper='1' effort='1' "
        "velocity='1'/></joint>",
        link, parent, link, origin);
    parent = link;
    origin = fmt::format("0 0 {}", bone.length > 0.0 ? bone.length : 0.01);
  }
  return urdf;
}

/// Of a hand with these fingers and a thumb.
std::vector<Segment> segmentsIn(const std::string& digit,
                                const std::vector<Bone>& finger,
                                const std::vector<Bone>& thumb) {
  const HandModel model = test::handOfText(
      "segments", test::boxLink("palm", "0.03 0.08 0.1", "0 0 -0.05") +
                      chain("index", 0.02, finger) + chain("middle", 0.0, finger) +
                      chain("ring", -0.02, finger) + chain("thumb", 0.05, thumb));
  LinkPoses X_SL;
  forwardKinematics(model, Pose::Identity(), skinReferencePose(model), X_SL);
  const Anatomy anatomy = anatomyOf(model, X_SL, {});
  const NamedDigit* found = anatomy.maybeDigit(digit);
  if (found == nullptr) return {};
  // Every segment ends in a link that one can see.
  for (const Segment& segment : found->segments)
    EXPECT_FALSE(
        model.links()[static_cast<std::size_t>(segment.links.back())].surface().empty())
        << segment.name;
  return found->segments;
}

const std::vector<Bone> three_hinges{{"1", 0.04}, {"2", 0.025}, {"3", 0.02}};

TEST(Segments, TakeTheHalvesOfARollingJointForOne) {
  const std::vector<Bone> rolling{{"1_half", 0.0}, {"1", 0.04},     {"2_half", 0.0},
                                  {"2", 0.025},    {"3_half", 0.0}, {"3", 0.02}};
  const std::vector<Segment> segments = segmentsIn("index", rolling, three_hinges);
  ASSERT_EQ(segments.size(), 3U);
  EXPECT_EQ(segments[0].name, "proximal");
  EXPECT_NEAR(segments[0].length(), 0.04 + 0.01, 1e-9);
  EXPECT_NEAR(segments[1].length(), 0.025 + 0.01, 1e-9);
  EXPECT_NEAR(segments[2].length(), 0.02, 1e-3);
  // What lies between the halves moves with what comes behind.
  EXPECT_EQ(segments[1].links.size(), 2U);
}

TEST(Segments, AThumbHasThreeBehindAStub) {
  const std::vector<Bone> stubbed{{"0", 0.014}, {"1", 0.03}, {"2", 0.022}, {"3", 0.02}};
  const std::vector<Segment> segments = segmentsIn("thumb", three_hinges, stubbed);
  ASSERT_EQ(segments.size(), 3U);
  EXPECT_EQ(segments[0].name, "proximal");
  EXPECT_NEAR(segments[0].length(), 0.03, 1e-9);
  EXPECT_EQ(segments[0].links.size(), 2U) << "the short link moves with it";

  std::vector<Bone> long_ones = stubbed;
  long_ones[0].length = 0.035;
  EXPECT_EQ(segmentsIn("thumb", three_hinges, long_ones).size(), 4U)
      << "a long link is a segment";
}

TEST(Segments, AStrandOfShortLinksHasThree) {
  // Six hinges a finger, as those that a tendon pulls through.
  const std::vector<Bone> strand{{"1", 0.013}, {"2", 0.009}, {"3", 0.013},
                                 {"4", 0.009}, {"5", 0.013}, {"6", 0.029}};
  for (const char* digit : {"index", "ring", "thumb"}) {
    const std::vector<Segment> segments = segmentsIn(digit, strand, strand);
    ASSERT_EQ(segments.size(), 3U) << digit;
    double whole = 0.0;
    for (const Segment& segment : segments) {
      EXPECT_GT(segment.length(), 0.02) << digit << ' ' << segment.name;
      whole += segment.length();
    }
    EXPECT_NEAR(whole, 0.086, 1e-3) << digit;
  }
}

}  // namespace
}  // namespace handgraft::hand
