#include "server/ledger.h"

#include <string>

#include <gtest/gtest.h>

namespace handgraft::server {
namespace {

using TestLedger = Ledger<std::string>;
using Verdict = TestLedger::Verdict;

TestLedger::ClientId client(std::uint8_t number) {
  return {number};
}

TEST(Ledger, BeginsARequestOnce) {
  TestLedger ledger;
  EXPECT_EQ(ledger.begin(client(1), 1).verdict, Verdict::kNew);
  EXPECT_EQ(ledger.begin(client(1), 1).verdict, Verdict::kRunning);
}

TEST(Ledger, RepeatsTheAnswerAfterwards) {
  TestLedger ledger;
  ledger.begin(client(1), 1);
  ledger.answer(client(1), 1, "yes", 3);
  const auto repeat = ledger.begin(client(1), 1);
  ASSERT_EQ(repeat.verdict, Verdict::kAnswered);
  EXPECT_EQ(*repeat.answer, "yes");
}

TEST(Ledger, KeepsClientsWithTheSameIdsApart) {
  TestLedger ledger;
  ledger.begin(client(1), 1);
  ledger.answer(client(1), 1, "one", 3);
  EXPECT_EQ(ledger.begin(client(2), 1).verdict, Verdict::kNew);
  ledger.answer(client(2), 1, "two", 3);
  EXPECT_EQ(*ledger.begin(client(1), 1).answer, "one");
  EXPECT_EQ(*ledger.begin(client(2), 1).answer, "two");
}

TEST(Ledger, TheFirstAnswerStands) {
  TestLedger ledger;
  ledger.answer(client(1), 1, "cancelled", 9);
  EXPECT_EQ(*ledger.answer(client(1), 1, "late", 4), "cancelled");
}

TEST(Ledger, NeverBeginsAForgottenRequestAgain) {
  TestLedger ledger({.answers_per_client = 2});
  for (std::uint64_t id = 1; id <= 4; ++id) {
    ASSERT_EQ(ledger.begin(client(1), id).verdict, Verdict::kNew);
    ledger.answer(client(1), id, "x", 1);
  }
  EXPECT_EQ(ledger.begin(client(1), 1).verdict, Verdict::kForgotten);
  EXPECT_EQ(ledger.begin(client(1), 2).verdict, Verdict::kForgotten);
  EXPECT_EQ(ledger.begin(client(1), 3).verdict, Verdict::kAnswered);
  EXPECT_EQ(ledger.begin(client(1), 4).verdict, Verdict::kAnswered);
}

TEST(Ledger, BeginsARequestThatALaterOneOvertook) {
  TestLedger ledger;
  ledger.begin(client(1), 2);
  ledger.answer(client(1), 2, "cancel", 1);
  EXPECT_EQ(ledger.begin(client(1), 1).verdict, Verdict::kNew);
}

TEST(Ledger, BoundsItsBytesButKeepsTheNewestAnswer) {
  TestLedger ledger({.bytes_per_client = 100, .bytes = 150});
  ledger.answer(client(1), 1, "large", 90);
  ledger.answer(client(1), 2, "larger", 120);
  EXPECT_EQ(ledger.bytes(), 120u);
  EXPECT_EQ(ledger.begin(client(1), 2).verdict, Verdict::kAnswered);
  ledger.answer(client(2), 1, "other", 80);
  EXPECT_EQ(ledger.bytes(), 80u);
  EXPECT_EQ(ledger.begin(client(1), 2).verdict, Verdict::kForgotten);
}

TEST(Ledger, ForgetsTheClientThatWasSilentLongest) {
  TestLedger ledger({.clients = 2});
  ledger.answer(client(1), 1, "a", 1);
  ledger.answer(client(2), 1, "b", 1);
  ledger.begin(client(1), 1);
  ledger.answer(client(3), 1, "c", 1);
  EXPECT_EQ(ledger.clientCount(), 2u);
  EXPECT_EQ(ledger.begin(client(1), 1).verdict, Verdict::kAnswered);
}

TEST(Ledger, KeepsAClientWhoseRequestRuns) {
  TestLedger ledger({.clients = 1});
  ledger.begin(client(1), 1);
  ledger.begin(client(2), 1);
  EXPECT_TRUE(ledger.running(client(1), 1));
}

}  // namespace
}  // namespace handgraft::server
