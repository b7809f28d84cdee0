#include "server/admission/request_deduplication.h"

#include <string>

#include <gtest/gtest.h>

namespace handgraft::server {
namespace {

using TestRequests = RequestDeduplication<std::string>;
using Verdict = TestRequests::Verdict;

TestRequests::ClientId client(std::uint8_t number) {
  return {number};
}

TEST(RequestDeduplication, BeginsARequestOnce) {
  TestRequests requests;
  EXPECT_EQ(requests.begin(client(1), 1).verdict, Verdict::kNew);
  EXPECT_EQ(requests.begin(client(1), 1).verdict, Verdict::kRunning);
}

TEST(RequestDeduplication, RepeatsTheAnswerAfterwards) {
  TestRequests requests;
  requests.begin(client(1), 1);
  requests.answer(client(1), 1, "yes", 3);
  const auto repeat = requests.begin(client(1), 1);
  ASSERT_EQ(repeat.verdict, Verdict::kAnswered);
  EXPECT_EQ(*repeat.answer, "yes");
}

TEST(RequestDeduplication, KeepsClientsWithTheSameIdsApart) {
  TestRequests requests;
  requests.begin(client(1), 1);
  requests.answer(client(1), 1, "one", 3);
  EXPECT_EQ(requests.begin(client(2), 1).verdict, Verdict::kNew);
  requests.answer(client(2), 1, "two", 3);
  EXPECT_EQ(*requests.begin(client(1), 1).answer, "one");
  EXPECT_EQ(*requests.begin(client(2), 1).answer, "two");
}

TEST(RequestDeduplication, TheFirstAnswerStands) {
  TestRequests requests;
  requests.answer(client(1), 1, "cancelled", 9);
  EXPECT_EQ(*requests.answer(client(1), 1, "late", 4), "cancelled");
}

TEST(RequestDeduplication, NeverBeginsAForgottenRequestAgain) {
  TestRequests requests({.answers_per_client = 2});
  for (std::uint64_t id = 1; id <= 4; ++id) {
    ASSERT_EQ(requests.begin(client(1), id).verdict, Verdict::kNew);
    requests.answer(client(1), id, "x", 1);
  }
  EXPECT_EQ(requests.begin(client(1), 1).verdict, Verdict::kForgotten);
  EXPECT_EQ(requests.begin(client(1), 2).verdict, Verdict::kForgotten);
  EXPECT_EQ(requests.begin(client(1), 3).verdict, Verdict::kAnswered);
  EXPECT_EQ(requests.begin(client(1), 4).verdict, Verdict::kAnswered);
}

TEST(RequestDeduplication, BeginsARequestThatALaterOneOvertook) {
  TestRequests requests;
  requests.begin(client(1), 2);
  requests.answer(client(1), 2, "cancel", 1);
  EXPECT_EQ(requests.begin(client(1), 1).verdict, Verdict::kNew);
}

TEST(RequestDeduplication, BoundsItsBytesButKeepsTheNewestAnswer) {
  TestRequests requests({.bytes_per_client = 100, .bytes = 150});
  requests.answer(client(1), 1, "large", 90);
  requests.answer(client(1), 2, "larger", 120);
  EXPECT_EQ(requests.bytes(), 120u);
  EXPECT_EQ(requests.begin(client(1), 2).verdict, Verdict::kAnswered);
  requests.answer(client(2), 1, "other", 80);
  EXPECT_EQ(requests.bytes(), 80u);
  EXPECT_EQ(requests.begin(client(1), 2).verdict, Verdict::kForgotten);
}

TEST(RequestDeduplication, ForgetsTheClientThatWasSilentLongest) {
  TestRequests requests({.clients = 2});
  requests.answer(client(1), 1, "a", 1);
  requests.answer(client(2), 1, "b", 1);
  requests.begin(client(1), 1);
  requests.answer(client(3), 1, "c", 1);
  EXPECT_EQ(requests.clientCount(), 2u);
  EXPECT_EQ(requests.begin(client(1), 1).verdict, Verdict::kAnswered);
}

TEST(RequestDeduplication, GivesBackAnswersOfTheSilent) {
  TestRequests requests;
  requests.begin(client(1), 1);
  requests.answer(client(1), 1, "yes", 3);
  requests.forgetSilent(std::chrono::hours(1));
  EXPECT_EQ(requests.bytes(), 3u);
  requests.forgetSilent(std::chrono::seconds(0));
  EXPECT_EQ(requests.bytes(), 0u);
  EXPECT_EQ(requests.begin(client(1), 1).verdict, Verdict::kForgotten);
}

TEST(RequestDeduplication, KeepsAClientWhoseRequestRuns) {
  TestRequests requests({.clients = 1});
  requests.begin(client(1), 1);
  requests.begin(client(2), 1);
  EXPECT_TRUE(requests.running(client(1), 1));
}

}  // namespace
}  // namespace handgraft::server
