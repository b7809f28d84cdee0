#include "core/hand/hand_model.h"

#include <cmath>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/hand/joint_numbers.h"

namespace handgraft::hand {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

Joint hinge(const std::string& name, const std::string& parent, const std::string& child) {
  Joint joint;
  joint.name = name;
  joint.type = JointType::kRevolute;
  joint.parent_link = parent;
  joint.child_link = child;
  joint.lower = -1.0;
  joint.upper = 1.0;
  return joint;
}

std::vector<Link> linksNamed(std::initializer_list<const char*> names) {
  std::vector<Link> links;
  for (const char* name : names)
    links.push_back({name, {}, {}});
  return links;
}

std::string faultOf(std::vector<Link> links, std::vector<Joint> joints) {
  try {
    const HandModel model("hand", std::move(links), std::move(joints));
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "no fault";
}

TEST(HandModel, SortsParentsBeforeChildren) {
  const HandModel model("hand", linksNamed({"tip", "middle", "palm"}),
                        {hinge("b", "middle", "tip"), hinge("a", "palm", "middle")});
  EXPECT_EQ(model.links()[0].name, "palm");
  for (int i = 0; i + 1 < model.linkCount(); ++i) {
    EXPECT_EQ(model.nodes()[static_cast<std::size_t>(i)].link, i + 1);
    EXPECT_LE(model.nodes()[static_cast<std::size_t>(i)].parent_link, i);
  }
  EXPECT_THAT(model.dofNames(), ElementsAre("b", "a"));  // in the order given
}

TEST(HandModel, NamesTheJointsOfALoop) {
  EXPECT_THAT(
      faultOf(linksNamed({"palm", "a", "b"}), {hinge("ab", "a", "b"), hinge("ba", "b", "a")}),
      AllOf(HasSubstr("'ab'"), HasSubstr("'ba'"), HasSubstr("loop")));
  EXPECT_THAT(faultOf(linksNamed({"a"}), {hinge("self", "a", "a")}), HasSubstr("'self'"));
}

TEST(HandModel, NamesALinkWithTwoParents) {
  EXPECT_THAT(
      faultOf(linksNamed({"palm", "a", "b"}),
              {hinge("pa", "palm", "a"), hinge("pb", "palm", "b"), hinge("ab", "a", "b")}),
      AllOf(HasSubstr("'b'"), HasSubstr("'pb'"), HasSubstr("'ab'")));
}

TEST(HandModel, NamesSeveralRoots) {
  EXPECT_THAT(faultOf(linksNamed({"palm", "stray"}), {}),
              AllOf(HasSubstr("'palm'"), HasSubstr("'stray'")));
}

TEST(HandModel, RefusesWhatIsNoModel) {
  EXPECT_THAT(faultOf({}, {}), HasSubstr("no links"));
  EXPECT_THAT(faultOf(linksNamed({"a", "a"}), {}), HasSubstr("'a' is there twice"));
  EXPECT_THAT(faultOf(linksNamed({"a"}), {hinge("j", "a", "ghost")}), HasSubstr("'ghost'"));
  Joint joint = hinge("j", "a", "b");
  joint.axis_J.setZero();
  EXPECT_THAT(faultOf(linksNamed({"a", "b"}), {joint}), HasSubstr("'j'"));
  joint = hinge("j", "a", "b");
  joint.lower = 2.0;
  EXPECT_THAT(faultOf(linksNamed({"a", "b"}), {joint}), HasSubstr("lower limit 2"));
  joint.lower = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(faultOf(linksNamed({"a", "b"}), {joint}), HasSubstr("not a number"));
  for (const JointNumber& number : kJointNumbers) {
    if (number.urdf_element == nullptr) continue;
    for (const double wrong : {-1.0, std::numeric_limits<double>::infinity(),
                               std::numeric_limits<double>::quiet_NaN()}) {
      joint = hinge("j", "a", "b");
      joint.*number.value = wrong;
      EXPECT_THAT(faultOf(linksNamed({"a", "b"}), {joint}),
                  AllOf(HasSubstr("'j'"), HasSubstr(number.name)));
    }
  }
}

TEST(HandModel, ComposesMimicsOfMimics) {
  Joint b = hinge("b", "l1", "l2");
  b.mimic = Mimic{"a", 2.0, 0.1};
  b.lower = -10.0;
  b.upper = 10.0;
  Joint c = hinge("c", "l2", "l3");
  c.mimic = Mimic{"b", -0.5, 0.3};
  c.lower = -10.0;
  c.upper = 10.0;
  const HandModel model("hand", linksNamed({"l0", "l1", "l2", "l3"}),
                        {hinge("a", "l0", "l1"), b, c});
  EXPECT_EQ(model.dofCount(), 1);
  EXPECT_EQ(model.mimicCount(), 2);
  EXPECT_DOUBLE_EQ(model.nodes()[2].multiplier, -1.0);
  EXPECT_DOUBLE_EQ(model.nodes()[2].offset, -0.5 * 0.1 + 0.3);
}

TEST(HandModel, NarrowsASourceByItsFollower) {
  Joint b = hinge("b", "l1", "l2");
  b.mimic = Mimic{"a", -2.0, 0.0};
  b.lower = -1.0;
  b.upper = 0.5;
  const HandModel model("hand", linksNamed({"l0", "l1", "l2"}), {hinge("a", "l0", "l1"), b});
  EXPECT_DOUBLE_EQ(model.lower()[0], -0.25);
  EXPECT_DOUBLE_EQ(model.upper()[0], 0.5);
}

TEST(HandModel, NamesMimicFaults) {
  Joint a = hinge("a", "l0", "l1");
  Joint b = hinge("b", "l1", "l2");
  a.mimic = Mimic{"b", 1.0, 0.0};
  b.mimic = Mimic{"a", 1.0, 0.0};
  EXPECT_THAT(faultOf(linksNamed({"l0", "l1", "l2"}), {a, b}), HasSubstr("form a loop"));
  b.mimic = Mimic{"ghost", 1.0, 0.0};
  EXPECT_THAT(faultOf(linksNamed({"l0", "l1", "l2"}), {a, b}), HasSubstr("'ghost'"));
}

TEST(HandModel, RestsAtZeroWithinTheLimits) {
  Joint a = hinge("a", "l0", "l1");
  a.lower = 0.2;
  const HandModel model("hand", linksNamed({"l0", "l1"}), {a});
  EXPECT_DOUBLE_EQ(model.restPose()[0], 0.2);
}

TEST(HandModel, RestsWhereItIsTold) {
  Joint a = hinge("a", "l0", "l1");
  a.lower = 0.2;
  a.upper = 1.0;
  const HandModel model("hand", linksNamed({"l0", "l1"}), {a});
  const HandModel bent = model.withRestPose(Eigen::VectorXd::Constant(1, 0.7));
  EXPECT_DOUBLE_EQ(bent.restPose()[0], 0.7);
  EXPECT_DOUBLE_EQ(bent.zeroPose()[0], 0.2);
  EXPECT_DOUBLE_EQ(model.restPose()[0], 0.2);
  const double nan = std::nan("");
  for (const double bad : {0.1, 1.1, nan})
    EXPECT_THROW((void)model.withRestPose(Eigen::VectorXd::Constant(1, bad)), InvalidInput);
  EXPECT_THROW((void)model.withRestPose(Eigen::VectorXd::Zero(2)), InvalidInput);
}

TEST(HandModel, NamesWhatItDoesNotHave) {
  const HandModel model("hand", linksNamed({"l0", "l1"}), {hinge("a", "l0", "l1")});
  EXPECT_EQ(model.linkIndex("l1"), 1);
  EXPECT_EQ(model.dofIndex("a"), 0);
  EXPECT_THROW((void)model.linkIndex("x"), InvalidInput);
  EXPECT_THROW((void)model.dofIndex("x"), InvalidInput);
}

}  // namespace
}  // namespace handgraft::hand
