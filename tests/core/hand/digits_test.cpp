// Which chains of joints are digits, and to which side they close, where limits alone mislead.
#include "core/hand/digits.h"

#include <numbers>
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/hand/kinematics.h"
#include "core/hand/skin.h"

#include "tests/core/hand/urdf_text.h"

namespace handgraft::hand {
namespace {

using test::boxLink;
using test::handOfText;

/// A joint from `parent`, about y of its own frame; `limits`: none where it turns for ever.
std::string hinge(const std::string& parent,
                  const std::string& child,
                  const std::string& origin,
                  const std::string& limits) {
  return fmt::format(
      "<joint name='{1}_joint' type='{3}'><parent link='{0}'/><child link='{1}'/><origin {2}/>"
      "<axis xyz='0 1 0'/>{4}</joint>",
      parent, child, origin, limits.empty() ? "continuous" : "revolute",
      limits.empty() ? "" : fmt::format("<limit {} effort='1' velocity='1'/>", limits));
}

/// A chain of three links along its z, from this origin on the palm; each joint but the first
/// is bent by `bend` where it is 0.
std::string finger(const std::string& name,
                   const std::string& origin,
                   double bend,
                   const std::string& limits) {
  std::string urdf;
  std::string parent = "palm";
  for (const int i : {1, 2, 3}) {
    const std::string link = fmt::format("{}_{}", name, i);
    urdf += boxLink(link, "0.012 0.012 0.03", "0 0 0.015");
    urdf += hinge(parent, link,
                  i == 1 ? origin : fmt::format("xyz='0 0 0.03' rpy='0 {} 0'", bend), limits);
    parent = link;
  }
  return urdf;
}

LinkPoses skinPoses(const HandModel& model) {
  LinkPoses X_SL;
  forwardKinematics(model, Pose::Identity(), skinReferencePose(model), X_SL);
  return X_SL;
}

/// The side to which a digit's first joint closes: 1 with its axis, -1 against it.
double closingSign(const HandModel& model, const LinkPoses& X_SL, const Digit& digit) {
  const HandModel::Node& first = model.nodes()[static_cast<std::size_t>(digit.nodes.front())];
  return digit.flexion_axis.dot(X_SL[static_cast<std::size_t>(first.link)].linear() *
                                first.axis_J);
}

std::string handOf(double bend, const std::string& limits) {
  return boxLink("palm", "0.03 0.08 0.1", "0 0 -0.05") +
         finger("f_a", "xyz='0 0.025 0'", bend, limits) +
         finger("f_b", "xyz='0 0 0'", bend, limits) +
         finger("f_c", "xyz='0 -0.025 0'", bend, limits);
}

TEST(Digits, AFingerThatIsShutWhereItsJointsAreZeroOpens) {
  const HandModel opens = handOfText("opens", handOf(-1.0, "lower='0' upper='1'"));
  LinkPoses X_SL = skinPoses(opens);
  const Digits found = findDigits(opens, X_SL);
  ASSERT_EQ(found.digits.size(), 3U);
  for (const Digit& digit : found.digits)
    EXPECT_NEAR(closingSign(opens, X_SL, digit), -1.0, 1e-9);
  // Straight at 0, a little bent, and bent over backwards a little: limits decide.
  for (const double bend : {0.0, 0.4, -0.15}) {
    const HandModel closes = handOfText("closes", handOf(bend, "lower='0' upper='1'"));
    X_SL = skinPoses(closes);
    for (const Digit& digit : findDigits(closes, X_SL).digits)
      EXPECT_NEAR(closingSign(closes, X_SL, digit), 1.0, 1e-9) << bend;
  }
}

TEST(Digits, FingersWithoutLimitsThatLieFlatCloseToOneSide) {
  // Around a base, 16 degrees below the horizontal where the joints are 0.
  std::string links = boxLink("palm", "0.09 0.09 0.06", "0 0 -0.03");
  for (const int i : {0, 1, 2}) {
    const double yaw = i == 2 ? std::numbers::pi : 0.0;
    const double x = i == 2 ? -0.04 : 0.05;
    const double y = i == 2 ? 0.0 : i == 0 ? -0.03 : 0.03;
    links += finger(
        fmt::format("f{}", i),
        fmt::format("xyz='{} {} 0.02' rpy='0 {} {}'", x, y, 0.5 * std::numbers::pi + 0.28, yaw),
        0.0, "");
  }
  const HandModel model = handOfText("flat", links);
  // At whatever pose the skin is made.
  for (const double bent : {-0.3, 0.0, 0.3}) {
    LinkPoses X_SL;
    forwardKinematics(model, Pose::Identity(), Eigen::VectorXd::Constant(9, bent), X_SL);
    const Digits found = findDigits(model, X_SL);
    ASSERT_EQ(found.digits.size(), 3U);
    for (const Digit& digit : found.digits)
      EXPECT_NEAR(closingSign(model, X_SL, digit), 1.0, 1e-9) << bent;
  }
}

TEST(Digits, AMarkerOnAJointOfItsOwnIsNone) {
  const HandModel model = handOfText(
      "marked", handOf(0.0, "lower='0' upper='1'") +
                    "<link name='f_d'><visual><geometry><sphere radius='0.001'/></geometry>"
                    "</visual></link>" +
                    hinge("palm", "f_d", "xyz='0 0 0'", "lower='0' upper='6'"));
  EXPECT_EQ(findDigits(model, skinPoses(model)).digits.size(), 3U);
}

}  // namespace
}  // namespace handgraft::hand
