#include "client/present/transfer_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "client/present/json_output.h"

#include "tests/client/present/example_grasp.h"

namespace handgraft::client {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::Not;

/// What a program reads.
json read(const client::json::Json& document) {
  return json::parse(client::json::written(document));
}

v1::TransferReply exampleTransfer() {
  v1::TransferReply reply = exampleGrasp().transfer;
  reply.session_id(9);
  reply.revision(2);
  reply.options().method(v1::LOG_MAP_AUTO);
  reply.options().interior_rings(1);
  return reply;
}

TEST(TransferText, ShowsFidelityMethodsLossesAndWhatWasDropped) {
  const std::string text = text::transfer(exampleTransfer());
  EXPECT_THAT(text, HasSubstr("session 9 revision 2: log maps auto, 1 interior rings"));
  EXPECT_THAT(text, testing::ContainsRegex("thumb +3 +1 +3.1 % +0.0 % +5.7 +0.0 +0.950 +0.00 "
                                           "+0.00 +exact/fast\n"));
  EXPECT_THAT(text, HasSubstr("dropped ring: the hand has no finger 'ring'"));
  EXPECT_THAT(text, HasSubstr("handgraft suggest 9 thumb"));
  EXPECT_THAT(text, Not(HasSubstr("sheets")));
}

TEST(TransferText, TellsWhyAPatchWasDroppedOnce) {
  v1::TransferReply reply = exampleTransfer();
  reply.notes() = {"the hand has no finger 'ring'", "the ring is a thumb's"};
  const std::string text = text::transfer(reply);
  EXPECT_THAT(text, Not(HasSubstr("note: the hand has no finger 'ring'")));
  EXPECT_THAT(text, HasSubstr("note: the ring is a thumb's"));
}

TEST(TransferText, ShowsNoShapeWhereNothingWasReached) {
  v1::TransferReply reply = exampleTransfer();
  reply.patches()[0].point_count(0);
  EXPECT_THAT(text::transfer(reply), testing::ContainsRegex("thumb +0 +1 +- +- +- +-"));
}

TEST(TransferText, SaysWhatIsFolded) {
  v1::TransferReply reply = exampleTransfer();
  reply.patches()[0].folded(2);
  EXPECT_THAT(text::transfer(reply), HasSubstr("thumb: 2 places lie under several sheets"));
}

TEST(TransferJson, SaysWhatTheReadmePromises) {
  const json document = json::parse(client::json::document(exampleTransfer()));
  EXPECT_EQ(document["session_id"], 9);
  EXPECT_EQ(document["revision"], 2);
  EXPECT_EQ(document["options"]["method"], "auto");
  EXPECT_EQ(document["options"]["interior_rings"], 1);
  ASSERT_EQ(document["patches"].size(), 2U);
  EXPECT_EQ(document["patches"][0]["boundary_count"], 3);
  EXPECT_EQ(document["patches"][0]["lost"][0]["reason"], "off the surface");
  EXPECT_EQ(document["patches"][0]["fidelity"]["area_ratio"], 0.95);
  EXPECT_EQ(document["patches"][1]["placed"], false);
}

v1::SuggestReply exampleSuggestion() {
  v1::SuggestReply reply;
  reply.session_id(9);
  reply.revision(2);
  reply.patch("thumb");
  reply.present(exampleGrasp().transfer.patches()[0]);
  v1::PlacementSuggestion one;
  one.root_S().face(7);
  one.moved_m(0.0032);
  one.turned_rad(-0.5);
  one.point_count(4);
  one.fidelity().distance_mean(0.02);
  one.fidelity().area_ratio(1.0);
  reply.suggestions().push_back(one);
  return reply;
}

TEST(SuggestText, PutsThePresentAndTheSuggestionsInOneTable) {
  const std::string text = text::suggestions(exampleSuggestion());
  EXPECT_THAT(text, testing::ContainsRegex("present +3 +1 +3.1 %"));
  EXPECT_THAT(text, testing::ContainsRegex("\n1 +3.20 +-28.6 +4 +0 +2.0 %"));
  EXPECT_THAT(text, HasSubstr("present loses: off the surface 1"));
}

TEST(SuggestText, SaysWhyItSuggestsNothing) {
  v1::SuggestReply reply = exampleSuggestion();
  reply.suggestions().clear();
  EXPECT_THAT(text::suggestions(reply), HasSubstr("no place within reach loses fewer"));
  reply.present().lost().clear();
  EXPECT_THAT(text::suggestions(reply), HasSubstr("nothing to better"));
}

TEST(SuggestJson, SaysWhatTheReadmePromises) {
  const v1::SuggestReply reply = exampleSuggestion();
  const json plain = read(client::json::suggestions(reply, {}));
  EXPECT_EQ(plain["patch"], "thumb");
  EXPECT_EQ(plain["present"]["point_count"], 3);
  EXPECT_EQ(plain["suggestions"][0]["root_S"]["face"], 7);
  EXPECT_EQ(plain["suggestions"][0]["turned_rad"], -0.5);
  EXPECT_EQ(plain["suggestions"][0]["lost_count"], 0);
  EXPECT_TRUE(plain["applied"].is_null());
  const json applied =
      read(client::json::suggestions(reply, client::json::Applied{1, 4, reply.present()}));
  EXPECT_EQ(applied["applied"]["suggestion"], 1);
  EXPECT_EQ(applied["applied"]["revision"], 4);
  EXPECT_EQ(applied["applied"]["report"]["name"], "thumb");
}

}  // namespace
}  // namespace handgraft::client
