// Where hands that nobody had tuned to have their palms, and where these look.
#include <algorithm>
#include <cmath>
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/base/progress.h"
#include "core/hand/anatomy.h"
#include "core/hand/contact_site.h"
#include "core/hand/finger_coordinates.h"
#include "core/hand/skin.h"
#include "core/hand/skin_cache.h"

#include "tests/core/hand/urdf_text.h"

namespace handgraft::hand {
namespace {

using test::boxLink;
using test::handOfText;

/// `more`: of the joint, beside where it is and how it turns.
std::string hinge(const std::string& joint,
                  const std::string& parent,
                  const std::string& child,
                  const std::string& origin,
                  const std::string& axis,
                  const std::string& more = "") {
  return fmt::format(
      "<joint name='{}' type='revolute'><parent link='{}'/><child link='{}'/><origin {}/>"
      "<axis xyz='{}'/><limit lower='0' upper='1.6' effort='1' velocity='1'/>{}</joint>",
      joint, parent, child, origin, axis, more);
}

/// Fingers to +z that close to +x, their last joints coupled and bent by 1 rad where the first
/// are straight, and a thumb beside them.
HandModel coupledHand() {
  std::string links = boxLink("palm", "0.03 0.08 0.1", "0 0 -0.05");
  for (int i = 0; i < 4; ++i) {
    const std::string name = i == 0 ? "index" : i == 1 ? "middle" : i == 2 ? "ring" : "little";
    links += boxLink(name + "_1", "0.012 0.014 0.038", "0 0 0.02");
    links += boxLink(name + "_2", "0.012 0.014 0.038", "0 0 0.02");
    links += hinge(name + "_a", "palm", name + "_1",
                   fmt::format("xyz='0 {} 0'", 0.03 - 0.02 * i), "0 1 0");
    links += hinge(name + "_b", name + "_1", name + "_2", "xyz='0 0 0.04'", "0 1 0",
                   fmt::format("<mimic joint='{}_a' multiplier='1' offset='1.0'/>", name));
  }
  links += boxLink("thumb_1", "0.014 0.038 0.014", "0 0.02 0");
  links += hinge("thumb_a", "palm", "thumb_1", "xyz='0 0.045 -0.06'", "0 0 -1");
  return handOfText("coupled", links);
}

/// Fingers to +z that close to +x above a palm whose edge towards them is a chamfer of 45
/// degrees; behind it the palm may be flat.
HandModel chamferedHand(bool has_flat) {
  std::string links =
      "<link name='palm'><visual><origin xyz='0 0 -0.0177' rpy='0 -0.785398 0'/><geometry>"
      "<box size='0.05 0.08 0.05'/></geometry></visual>";
  if (has_flat)
    links +=
        "<visual><origin xyz='0.0 0 -0.0577'/><geometry><box size='0.0707 0.08 0.08'/>"
        "</geometry></visual>";
  links += "</link>";
  for (int i = 0; i < 3; ++i) {
    const std::string name = i == 0 ? "index" : i == 1 ? "middle" : "ring";
    links += boxLink(name + "_1", "0.012 0.014 0.048", "0 0 0.025");
    links += boxLink(name + "_2", "0.012 0.014 0.048", "0 0 0.025");
    links += hinge(name + "_a", "palm", name + "_1",
                   fmt::format("xyz='0 {} 0.02'", 0.025 - 0.025 * i), "0 1 0");
    links += hinge(name + "_b", name + "_1", name + "_2", "xyz='0 0 0.05'", "0 1 0");
  }
  return handOfText("chamfered", links);
}

/// Three like fingers about a base's axis, +z, that close towards it; or with limits that do
/// not say so, and axes this way and that.
HandModel handOfThree(bool says_how_they_close = true) {
  std::string links = boxLink("base", "0.09 0.09 0.03", "0 0 -0.015");
  for (int i = 0; i < 3; ++i) {
    const std::string name = fmt::format("finger_{}", i);
    const double turn = 2.0 * 3.14159265358979 * i / 3.0;
    const char* axis = says_how_they_close || i == 1 ? "0 -1 0" : "0 1 0";
    links += boxLink(name + "_1", "0.014 0.014 0.048", "0 0 0.025");
    links += boxLink(name + "_2", "0.014 0.014 0.048", "0 0 0.025");
    links += hinge(name + "_a", "base", name + "_1",
                   fmt::format("xyz='{} {} 0' rpy='0 0 {}'", 0.04 * std::cos(turn),
                               0.04 * std::sin(turn), turn),
                   axis);
    links += hinge(name + "_b", name + "_1", name + "_2", "xyz='0 0 0.05'", axis);
  }
  if (!says_how_they_close)
    for (auto at = links.find("lower='0'"); at != std::string::npos;
         at = links.find("lower='0'"))
      links.replace(at, 9, "lower='-1.6'");
  return handOfText("three", links);
}

/// Two fingers side by side and one against them, which alone has a finger's name.
HandModel gripperOfThree() {
  std::string links = boxLink("base", "0.09 0.09 0.03", "0 0 -0.015");
  const auto add = [&](const std::string& name, const std::string& origin,
                       const std::string& axis) {
    links += boxLink(name + "_link_1", "0.014 0.014 0.048", "0 0 0.025");
    links += boxLink(name + "_link_2", "0.014 0.014 0.048", "0 0 0.025");
    links += hinge(name + "_joint_1", "base", name + "_link_1", origin, axis);
    links +=
        hinge(name + "_joint_2", name + "_link_1", name + "_link_2", "xyz='0 0 0.05'", axis);
  };
  add("finger_1", "xyz='-0.04 0.03 0'", "0 1 0");
  add("finger_2", "xyz='-0.04 -0.03 0'", "0 1 0");
  add("finger_middle", "xyz='0.04 0 0'", "0 -1 0");
  return handOfText("gripper", links);
}

const ContactSite* palmIn(const std::vector<ContactSite>& sites) {
  for (const ContactSite& site : sites)
    if (site.name == "palm") return &site;
  return nullptr;
}

std::vector<ContactSite> sitesOf(const HandModel& model) {
  return findContactSites(model, SkinCache::fromEnvironment().get(model, {}, Progress()));
}

TEST(Palm, LooksWhereTheFingersFirstBonesCloseTo) {
  const HandModel model = coupledHand();
  const auto sites = sitesOf(model);
  const ContactSite* palm = palmIn(sites);
  ASSERT_NE(palm, nullptr);
  EXPECT_EQ(palm->link, "palm");
  EXPECT_GT(palm->n_L.x(), 0.95) << palm->n_L.transpose();
  EXPECT_LT(palm->direction_L.z(), -0.95) << palm->direction_L.transpose();
  EXPECT_LT(palm->p_L.z(), -0.01) << "within the palm's face, not on its edge";

  LinkPoses X_SL;
  forwardKinematics(model, Pose::Identity(), skinReferencePose(model), X_SL);
  const Anatomy anatomy = anatomyOf(model, X_SL, {});
  ASSERT_TRUE(anatomy.palm.has_value());
  EXPECT_GT(anatomy.palm->facing_S.x(), 0.99);
  EXPECT_GT(anatomy.palm->outward_S.z(), 0.99);
}

TEST(Palm, IsWhereItsOwnSitePutsIt) {
  // What the fingers' joints say is wrong on some hands; its sites.yaml is to put that right.
  const HandModel model = coupledHand();
  ContactSite site;
  site.name = "palm";
  site.link = "palm";
  site.p_L = {-0.015, 0.0, -0.04};
  site.n_L = {-1.0, 0.0, 0.0};
  site.direction_L = {0.0, 0.0, -1.0};
  LinkPoses X_SL;
  forwardKinematics(model, Pose::Identity(), skinReferencePose(model), X_SL);
  const Anatomy anatomy = anatomyOf(model, X_SL, {site});
  ASSERT_TRUE(anatomy.palm.has_value());
  EXPECT_LT(anatomy.palm->facing_S.x(), -0.99);
  EXPECT_GT(anatomy.palm->outward_S.z(), 0.99);

  const Skin skin = SkinCache::fromEnvironment().get(model, {}, Progress());
  HandLocation middle;
  middle.digit = kPalmPart;
  middle.along = middle.across = 0.5;
  const auto spot = FingerCoordinates(model, skin, {site}).spotAt(middle);
  ASSERT_TRUE(spot.has_value());
  EXPECT_LT(geometry::positionOf(skin.mesh(), spot->root_S).x(), -0.014) << "on its back";
}

TEST(Palm, OfFingersAllAroundItLooksAlongThem) {
  const auto sites = sitesOf(handOfThree());
  const ContactSite* palm = palmIn(sites);
  ASSERT_NE(palm, nullptr);
  EXPECT_EQ(palm->link, "base");
  EXPECT_GT(palm->n_L.z(), 0.95) << palm->n_L.transpose();
  EXPECT_LT(palm->p_L.head<2>().norm(), 0.03);
}

TEST(Palm, OfFingersAllAroundItWhoseLimitsSayNothingIsBetweenThem) {
  const HandModel model = handOfThree(false);
  const auto sites = sitesOf(model);
  LinkPoses X_SL;
  forwardKinematics(model, Pose::Identity(), skinReferencePose(model), X_SL);
  ASSERT_EQ(sites.size(), 4u);
  for (const ContactSite& site : sites) {
    const Eigen::Affine3d X_SLink(X_SL[static_cast<std::size_t>(model.linkIndex(site.link))]);
    const Eigen::Vector3d n_S = X_SLink.linear() * site.n_L;
    if (site.name == "palm") {
      EXPECT_GT(n_S.z(), 0.95) << n_S.transpose();
    } else {
      const Eigen::Vector2d inwards = -X_SLink.translation().head<2>().normalized();
      EXPECT_GT(n_S.head<2>().dot(inwards), 0.7) << site.name << ": " << n_S.transpose();
    }
  }
}

TEST(Palm, IsNotOnAChamferWhereItHasAFlatPlace) {
  const HandModel model = chamferedHand(true);
  const auto sites = sitesOf(model);
  const ContactSite* palm = palmIn(sites);
  ASSERT_NE(palm, nullptr);
  EXPECT_GT(palm->n_L.x(), 0.95) << palm->n_L.transpose();
  EXPECT_LT(palm->p_L.z(), -0.025) << "not on its edge";
  LinkPoses X_SL;
  forwardKinematics(model, Pose::Identity(), skinReferencePose(model), X_SL);
  EXPECT_TRUE(anatomyOf(model, X_SL, sites).notes.empty());
}

TEST(Palm, ThatIsAllChamferIsTold) {
  const HandModel model = chamferedHand(false);
  const auto sites = sitesOf(model);
  ASSERT_NE(palmIn(sites), nullptr);
  LinkPoses X_SL;
  forwardKinematics(model, Pose::Identity(), skinReferencePose(model), X_SL);
  const std::vector<std::string> notes = anatomyOf(model, X_SL, sites).notes;
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_NE(notes.front().find("looks 45 degrees away"), std::string::npos) << notes.front();
}

TEST(Thumb, IsWhatStandsAgainstTheOthersThoughItAloneIsCalledMiddle) {
  const HandModel model = gripperOfThree();
  LinkPoses X_SL;
  forwardKinematics(model, Pose::Identity(), skinReferencePose(model), X_SL);
  const Anatomy anatomy = anatomyOf(model, X_SL, {});
  const NamedDigit* thumb = anatomy.maybeDigit("thumb");
  ASSERT_NE(thumb, nullptr);
  const int tip = thumb->digit.tip_links.front();
  EXPECT_EQ(model.links()[static_cast<std::size_t>(tip)].name, "finger_middle_link_2");
  EXPECT_TRUE(std::any_of(anatomy.notes.begin(), anatomy.notes.end(), [](const auto& note) {
    return note.find("stands against the others") != std::string::npos;
  }));
}

}  // namespace
}  // namespace handgraft::hand
