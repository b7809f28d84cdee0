#include <cstring>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "client/present/json_output.h"
#include "client/present/model_text.h"
#include "client/present/skin_file.h"
#include "core/base/error.h"

#include "tests/client/hands.h"

namespace handgraft::client {
namespace {

using nlohmann::json;
using testing::ContainsRegex;
using testing::HasSubstr;
using testing::Not;

v1::ModelDescription described(const v1::HandDescription& hand) {
  v1::ModelDescription description;
  description.hand(hand);
  return description;
}

TEST(HandText, TellsJointsSitesAndSkin) {
  const std::string text = text::hand(test::flatHand());
  EXPECT_THAT(text, HasSubstr("hand flat: 2 joints, 4 links, 4 sites"));
  EXPECT_THAT(text, HasSubstr("revolute   palm > index_tip"));
  EXPECT_THAT(text, HasSubstr("prismatic  palm > index_tip"));
  EXPECT_THAT(text, HasSubstr("sites found on the skin:"));
  EXPECT_THAT(text, HasSubstr("skin is sound"));
  EXPECT_THAT(text, HasSubstr("  wrap alpha 3 mm: kept\n  8 vertices\n"));
}

TEST(HandText, TellsMimicsCarrierPosesAndMirroring) {
  v1::HandDescription hand = test::flatHand();
  hand.mirrored(true);
  hand.free_root_joints() = {"root_x", "root_y"};
  hand.poses().resize(1);
  hand.poses()[0].name("fist");
  v1::MimicInfo mimic;
  mimic.joint("ip");
  mimic.source("mcp");
  mimic.multiplier(0.5);
  mimic.offset(-0.1);
  hand.mimics().push_back(mimic);
  hand.joints()[0].lower(-std::numeric_limits<double>::infinity());
  hand.joints()[0].upper(std::numeric_limits<double>::infinity());
  const std::string text = text::hand(hand);
  EXPECT_THAT(text, HasSubstr("1 mimic joint,"));
  EXPECT_THAT(text, HasSubstr("mimic ip = 0.5 * mcp - 0.1\n"));
  EXPECT_THAT(text, HasSubstr("cut off: root_x, root_y\n"));
  EXPECT_THAT(text, HasSubstr("named poses: fist\n"));
  EXPECT_THAT(text, HasSubstr("mirrored"));
  EXPECT_THAT(text, HasSubstr("continuous"));
}

TEST(HandText, TellsAnglesInDegreesAndSlidesInMillimetres) {
  v1::HandDescription hand = test::flatHand();
  for (v1::JointInfo& joint : hand.joints()) {
    joint.lower(-0.1);
    joint.upper(0.25);
    joint.velocity_limit(2.0);
  }
  hand.rest_positions({0.05, 0.05});
  const std::string text = text::hand(hand);
  EXPECT_THAT(text, ContainsRegex("revolute .* -5.7 +14.3 +114.6 +2.9 +deg\n"));
  EXPECT_THAT(text, ContainsRegex("prismatic .* -100.0 +250.0 +2000 +50.0 +mm\n"));
}

TEST(HandText, TellsWhatNamedEachDigit) {
  v1::HandDescription hand = test::flatHand();
  hand.digits().resize(3);
  for (const auto& [i, name] :
       {std::pair(0, "thumb"), std::pair(1, "index"), std::pair(2, "f1")})
    hand.digits()[i].name(name);
  hand.digits()[1].named_by_file(true);
  EXPECT_THAT(text::hand(hand), ContainsRegex("thumb +its shape"));
  EXPECT_THAT(text::hand(hand), ContainsRegex("index +names in its file"));
  hand.sites_found(false);
  EXPECT_THAT(text::hand(hand), ContainsRegex("thumb +its site"));
  EXPECT_THAT(text::hand(hand), ContainsRegex("f1 +its shape"));
}

TEST(HandText, SaysNothingOfASkinThatIsNotKnown) {
  v1::HandDescription hand = test::flatHand();
  hand.skin_report().clear();
  EXPECT_THAT(text::hand(hand), Not(HasSubstr("skin is")));
}

TEST(SkinText, NamesEveryFlaw) {
  v1::SkinReport report;
  report.pieces(3);
  report.genus(2);
  report.crossing_faces(1);
  const std::string text = text::skin(report);
  EXPECT_THAT(text, HasSubstr("NOT sound: not closed, 3 pieces"));
  EXPECT_THAT(text, HasSubstr("genus 2, 1 face cross others"));
}

TEST(HandJson, SaysWhatTheReadmePromises) {
  v1::HandDescription hand = test::flatHand();
  hand.poses().resize(1);
  hand.poses()[0].name("fist");
  hand.poses()[0].joint_positions() = {1.25, 0.0};
  const json document = json(client::json::description(described(hand)));
  EXPECT_EQ(document["joints"][0]["parent_link"], "palm");
  EXPECT_EQ(document["poses"][0]["joint_positions"][0], 1.25);
  EXPECT_EQ(document["sites_found"], true);
  EXPECT_EQ(document["sites"].size(), 4U);
  EXPECT_EQ(document["skin_report"]["valid"], true);
  EXPECT_EQ(document["skin_report"]["steps"][0]["action"], "wrap");
  hand.skin_report().clear();
  EXPECT_TRUE(json(client::json::description(described(hand)))["skin_report"].is_null());
}

TEST(ContactsText, MeasuresEachPatch) {
  v1::ContactsDescription set = test::squareOnBox();
  const std::string text = text::contacts(set);
  EXPECT_THAT(text, HasSubstr("contacts box_1 on box: 1 patch\n"));
  EXPECT_THAT(text, HasSubstr("index       4       160.0      1600       1      given\n"));
  EXPECT_THAT(text, HasSubstr("note: dropped nothing\n"));
  EXPECT_THAT(text, Not(HasSubstr("touched by")));
  set.patches()[0].direction_O().clear();
  set.demonstrator(v1::CHIRALITY_LEFT);
  EXPECT_THAT(text::contacts(set),
              testing::AllOf(HasSubstr("open\n"), HasSubstr("touched by a left hand\n")));
}

TEST(ContactsJson, HoldsTheSetAsItsFile) {
  v1::ModelDescription description;
  description.contacts(test::squareOnBox());
  const json document = json(client::json::description(description));
  EXPECT_EQ(document["kind"], "contacts");
  EXPECT_EQ(document["file"], test::squareOnBox().file());
  EXPECT_TRUE(document["contact_map"].is_null());
}

TEST(SkinFile, HoldsEachFaceWithItsLink) {
  const v1::HandDescription hand = test::flatHand();
  const std::string ply = skinPly(hand);
  const std::size_t end = ply.find("end_header\n");
  ASSERT_NE(end, std::string::npos);
  EXPECT_THAT(ply.substr(0, end), HasSubstr("comment links 0=palm 1=index_tip"));
  EXPECT_THAT(ply.substr(0, end), HasSubstr("element vertex 8\n"));
  EXPECT_THAT(ply.substr(0, end), HasSubstr("element face 12\n"));
  const std::size_t body = end + std::strlen("end_header\n");
  constexpr std::size_t kFaceBytes = 1 + 3 * 4 + 4;
  ASSERT_EQ(ply.size(), body + 8 * 12 + 12 * kFaceBytes);
  const auto link_of = [&](std::size_t face) {
    std::int32_t link = 0;
    std::memcpy(&link, ply.data() + body + 8 * 12 + face * kFaceBytes + 13, sizeof link);
    return link;
  };
  EXPECT_EQ(link_of(0), 0);
  EXPECT_EQ(link_of(3), 1);
  EXPECT_EQ(link_of(4), -1);
}

TEST(SkinFile, RefusesWhatContradictsItself) {
  v1::HandDescription hand = test::flatHand();
  hand.skin_face_links().pop_back();
  EXPECT_THROW(skinPly(hand), TransportError);
  hand = test::flatHand();
  hand.skin_S().triangles()[0] = 8;
  EXPECT_THROW(skinPly(hand), TransportError);
}

}  // namespace
}  // namespace handgraft::client
