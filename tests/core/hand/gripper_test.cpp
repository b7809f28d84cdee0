// Grippers: which of their links are jaws, and where these touch.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/base/progress.h"
#include "core/hand/contact_site.h"
#include "core/hand/digits.h"
#include "core/hand/skin.h"
#include "core/hand/skin_cache.h"

#include "tests/core/hand/urdf_text.h"

namespace handgraft::hand {
namespace {

using test::boxLink;
using test::handOfText;

struct JointText {
  std::string name;
  std::string type = "revolute";
  std::string parent;
  std::string child;
  std::string origin;  ///< xyz and rpy
  std::string axis;
  std::string upper = "0.8";
  double multiplier = 0.0;  ///< of `drive`; 0: is it
};

std::string joint(const JointText& text) {
  const std::string mimic =
      text.multiplier == 0.0
          ? ""
          : fmt::format("<mimic joint='drive' multiplier='{}'/>", text.multiplier);
  return fmt::format(
      "<joint name='{}' type='{}'><parent link='{}'/><child link='{}'/><origin {}/><axis "
      "xyz='{}'/><limit lower='0' upper='{}' effort='1' velocity='1'/>{}</joint>",
      text.name, text.type, text.parent, text.child, text.origin, text.axis, text.upper, mimic);
}

/// Two jaws along z that close towards each other along x: a bar that is driven, a pad that
/// turns back as much, so that it stays parallel, and, if it `has_guides`, a second bar beside
/// the first.
HandModel parallelGripper(bool has_guides) {
  std::string links = boxLink("base", "0.07 0.05 0.06", "0 0 -0.03");
  for (const bool is_left : {true, false}) {
    const std::string side = is_left ? "left" : "right";
    const std::string turn = is_left ? "0 0 0" : "0 0 3.14159265358979";
    const double x = is_left ? 1.0 : -1.0;
    links += boxLink(side + "_bar", "0.012 0.02 0.05", "0 0 0.025");
    links += boxLink(side + "_pad", "0.012 0.02 0.045", "0 0 0.0225");
    links += joint({is_left ? "drive" : side + "_drive", "revolute", "base", side + "_bar",
                    fmt::format("xyz='{} 0 0' rpy='{}'", 0.045 * x, turn), "0 -1 0", "0.8",
                    is_left ? 0.0 : 1.0});
    links += joint({side + "_back", "revolute", side + "_bar", side + "_pad", "xyz='0 0 0.052'",
                    "0 1 0", "0.8", 1.0});
    if (!has_guides) continue;
    links += boxLink(side + "_guide", "0.008 0.018 0.05", "0 0 0.025");
    links += joint({side + "_guide_joint", "revolute", "base", side + "_guide",
                    fmt::format("xyz='{} 0 0.004' rpy='{}'", 0.028 * x, turn), "0 -1 0", "0.8",
                    1.0});
  }
  return handOfText(has_guides ? "guided" : "parallel", links);
}

/// Two jaws along z that slide apart along y, and touch where they are at rest; with more links
/// and joints.
HandModel slidingGripper(const std::string& more = "") {
  const std::string box =
      "<origin xyz='0 0 -0.025'/><geometry><box size='0.04 0.12 0.05'/></geometry>";
  std::string links = fmt::format(
      "<link name='base'><visual>{0}</visual><collision>{0}</collision></link>{1}", box, more);
  links += boxLink("jaw_1", "0.02 0.014 0.05", "0 0.007 0.027");
  links += boxLink("jaw_2", "0.02 0.014 0.05", "0 -0.007 0.027");
  links += joint({"drive", "prismatic", "base", "jaw_1", "xyz='0 0 0'", "0 1 0", "0.04", 0.0});
  links +=
      joint({"drive_2", "prismatic", "base", "jaw_2", "xyz='0 0 0'", "0 -1 0", "0.04", 1.0});
  return handOfText("sliding", links);
}

Digits digitsOf(const HandModel& model) {
  LinkPoses X_SL;
  forwardKinematics(model, Pose::Identity(), skinReferencePose(model), X_SL);
  return findDigits(model, X_SL);
}

/// Of jaws, on this link, that look to the middle along axis `i`; and that the palm looks out
/// between them.
void expectJaws(const HandModel& model, const std::vector<std::string>& links, int i) {
  const Skin skin = SkinCache::fromEnvironment().get(model, {}, Progress());
  LinkPoses X_SL;
  forwardKinematics(model, Pose::Identity(), skin.qReference(), X_SL);
  const auto sites = findContactSites(model, skin);
  ASSERT_EQ(sites.size(), 3U);
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_EQ(sites[k].name, k == 0 ? "thumb" : "index");
    EXPECT_NE(std::find(links.begin(), links.end(), sites[k].link), links.end())
        << sites[k].link;
    const Pose& X = X_SL[static_cast<std::size_t>(model.linkIndex(sites[k].link))];
    const Eigen::Vector3d p_S = X * sites[k].p_L;
    const Eigen::Vector3d n_S = X.linear() * sites[k].n_L;
    EXPECT_LT(n_S[i] * p_S[i], 0.0) << "looks away from the other jaw";
    EXPECT_GT(std::abs(n_S[i]), 0.95) << n_S.transpose();
  }
  EXPECT_NE(sites[0].link, sites[1].link);
  EXPECT_EQ(sites[2].name, "palm");
  EXPECT_EQ(sites[2].link, "base");
  EXPECT_GT(sites[2].n_L.z(), 0.95);
}

TEST(Gripper, HasParallelJawsThatCloseAsTheirFirstJointTurns) {
  const HandModel model = parallelGripper(false);
  ASSERT_EQ(digitsOf(model).digits.size(), 2U);
  expectJaws(model, {"left_pad", "right_pad"}, 0);
}

TEST(Gripper, HasBarsThatGuideItsJawsAndAreNone) {
  const HandModel model = parallelGripper(true);
  const Digits found = digitsOf(model);
  ASSERT_EQ(found.digits.size(), 2U);
  for (const Digit& digit : found.digits)
    EXPECT_EQ(digit.nodes.size(), 2U);
  expectJaws(model, {"left_pad", "right_pad"}, 0);
}

TEST(Gripper, HasJawsThatSlide) {
  const HandModel model = slidingGripper();
  // Where they touch there is no skin between them.
  EXPECT_GT(skinReferencePose(model)[0], 0.004);
  const Digits found = digitsOf(model);
  ASSERT_EQ(found.digits.size(), 2U);
  for (const Digit& digit : found.digits) {
    EXPECT_GT(digit.outward.z(), 0.95);
    EXPECT_LT(digit.closing.y() * digit.tip.y(), 0.0);
    EXPECT_NEAR(digit.flexion_axis.cross(digit.outward).dot(digit.closing), 1.0, 1e-9);
  }
  expectJaws(model, {"jaw_1", "jaw_2"}, 1);
}

TEST(Gripper, HasJawsOnLongRacks) {
  HandModel model = handOfText("racks", [] {
    std::string links = boxLink("base", "0.12 0.05 0.06", "0 0 -0.03");
    for (const bool is_left : {true, false}) {
      const std::string side = is_left ? "left" : "right";
      const double x = is_left ? 1.0 : -1.0;
      // Longer along its slide than the jaw that is fixed to it stands out.
      links += boxLink(side + "_rack", "0.08 0.008 0.01", fmt::format("{} 0 0", -0.02 * x));
      links += boxLink(side + "_jaw", "0.01 0.02 0.04", "0 0 0.02");
      links += joint({is_left ? "drive" : "drive_2", "prismatic", "base", side + "_rack",
                      fmt::format("xyz='{} {} 0.01'", 0.04 * x, 0.012 * x),
                      fmt::format("{} 0 0", -x), "0.03", is_left ? 0.0 : 1.0});
      links += joint({side + "_mount", "fixed", side + "_rack", side + "_jaw",
                      "xyz='0 0 0.005'", "0 0 1", "0", 0.0});
    }
    return links;
  }());
  const Digits found = digitsOf(model);
  ASSERT_EQ(found.digits.size(), 2U);
  for (const Digit& digit : found.digits)
    EXPECT_GT(digit.outward.z(), 0.95) << digit.outward.transpose();
  expectJaws(model, {"left_jaw", "right_jaw"}, 0);
}

TEST(Gripper, HasJawsThatAreShutWhereTheirJointsAreZero) {
  std::string links = boxLink("base", "0.07 0.05 0.06", "0 0 -0.03");
  for (const bool is_left : {true, false}) {
    const double x = is_left ? 1.0 : -1.0;
    const std::string name = is_left ? "left" : "right";
    links += boxLink(name, "0.012 0.02 0.09", fmt::format("{} 0 0.045", 0.007 * x));
    links += joint({is_left ? "drive" : "drive_2", "revolute", "base", name,
                    fmt::format("xyz='{} 0 0'", 0.01 * x), fmt::format("0 {} 0", x), "0.5",
                    is_left ? 0.0 : 1.0});
  }
  const HandModel model = handOfText("shut", links);
  const Digits found = digitsOf(model);
  ASSERT_EQ(found.digits.size(), 2U);
  for (const Digit& digit : found.digits)
    EXPECT_LT(digit.closing.x() * digit.tip.x(), 0.0) << digit.closing.transpose();
}

TEST(Gripper, HasAJawThatForksIntoTwoPads) {
  // One bar carries two pads that turn back, against a jaw of one; a bar guides the fork.
  std::string links = boxLink("base", "0.07 0.08 0.06", "0 0 -0.03") +
                      boxLink("fork", "0.012 0.07 0.05", "0 0 0.025") +
                      boxLink("guide", "0.008 0.018 0.05", "0 0 0.025") +
                      boxLink("bar", "0.012 0.02 0.05", "0 0 0.025");
  links += joint({"drive", "revolute", "base", "fork", "xyz='0.045 0 0'", "0 -1 0"});
  links += joint({"guide_joint", "revolute", "base", "guide", "xyz='0.028 0 0.004'", "0 -1 0",
                  "0.8", 1.0});
  for (const int side : {1, 2}) {
    const std::string pad = fmt::format("pad_{}", side);
    links += boxLink(pad, "0.012 0.02 0.045", "0 0 0.0225");
    links += joint({pad + "_joint", "revolute", "fork", pad,
                    fmt::format("xyz='0 {} 0.052'", side == 1 ? 0.032 : -0.032), "0 1 0", "0.8",
                    1.0});
  }
  links +=
      joint({"bar_joint", "revolute", "base", "bar", "xyz='-0.045 0 0'", "0 1 0", "0.8", 1.0});
  links += boxLink("pad_3", "0.012 0.02 0.045", "0 0 0.0225");
  links += joint(
      {"pad_3_joint", "revolute", "bar", "pad_3", "xyz='0 0 0.052'", "0 -1 0", "0.8", 1.0});
  const HandModel model = handOfText("forked", links);
  const Digits found = digitsOf(model);
  ASSERT_EQ(found.digits.size(), 3U) << "the guide is none";
  for (const Digit& digit : found.digits)
    EXPECT_LT(digit.closing.x() * digit.tip.x(), 0.0) << digit.closing.transpose();
}

TEST(Gripper, WearsACameraThatIsNoPalm) {
  const HandModel model = slidingGripper(
      "<link name='camera'><visual><geometry><box size='0.05 0.03 0.03'/></geometry></visual>"
      "</link>" +
      joint({"mount", "fixed", "base", "camera", "xyz='0.03 0 0.015'", "0 0 1", "0", 0.0}));
  EXPECT_EQ(digitsOf(model).palm_links, std::vector<int>{model.linkIndex("base")});
  expectJaws(model, {"jaw_1", "jaw_2"}, 1);
}

TEST(Gripper, KeepsAJawOfOneJointThatStandsAgainstALongerOne) {
  // As a bar it is short, driven by the same motor and in the same plane.
  std::string links = boxLink("base", "0.07 0.05 0.06", "0 0 -0.03");
  links += boxLink("short", "0.012 0.02 0.05", "0 0 0.025");
  links += boxLink("long_1", "0.012 0.02 0.05", "0 0 0.025");
  links += boxLink("long_2", "0.012 0.02 0.045", "0 0 0.0225");
  links += joint({"drive", "revolute", "base", "long_1", "xyz='0.04 0 0'", "0 -1 0"});
  links +=
      joint({"a", "revolute", "long_1", "long_2", "xyz='0 0 0.052'", "0 -1 0", "0.8", 0.5});
  links += joint({"b", "revolute", "base", "short", "xyz='-0.04 0 0'", "0 1 0", "0.8", 1.0});
  EXPECT_EQ(digitsOf(handOfText("unequal", links)).digits.size(), 2U);
}

}  // namespace
}  // namespace handgraft::hand
