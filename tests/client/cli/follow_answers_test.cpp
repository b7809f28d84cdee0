// What `motion follow` makes of what a session says while frames are sent.
#include "client/cli/commands/follow_answers.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace handgraft::client {
namespace {

using std::chrono::milliseconds;
using testing::Optional;

constexpr const char* kMillimetres =
    "demonstrator: values: to its tip 181 m; a hand has 0.05 to 0.5: millimetres?";
constexpr const char* kAnother =
    "demonstrator: another one is followed, until it has stopped for 500 ms";
constexpr const char* kTooLittle =
    "demonstrator: touches the object with 1 of the 3 parts that a hand begins with";

v1::PoseSolution answerTo(double time_s) {
  v1::PoseSolution solution;
  solution.time_s().push_back(time_s);
  solution.joint_positions({0.5});
  return solution;
}

class FollowAnswersTest : public testing::Test {
 protected:
  FollowAnswers::Clock::time_point start = FollowAnswers::Clock::now();
  FollowAnswers answers{""};
};

TEST_F(FollowAnswersTest, TheFirstRefusalIsKept) {
  answers.sent(0.0, start);
  answers.said(std::string("weak grasp; ") + kMillimetres, start + milliseconds(20));
  answers.said(kAnother, start + milliseconds(40));
  EXPECT_THAT(answers.refusal(), Optional(std::string(kMillimetres)));
}

TEST_F(FollowAnswersTest, TouchingTooLittleIsNoRefusalAndTellsWhyNothingCame) {
  answers.sent(0.0, start);
  answers.said(kTooLittle, start + milliseconds(20));
  EXPECT_FALSE(answers.refusal().has_value());
  EXPECT_EQ(answers.whyNone(), kTooLittle);
  EXPECT_TRUE(std::isnan(answers.latency(0.5)));
}

TEST_F(FollowAnswersTest, SomebodyElseWhoIsFollowedRefusesUs) {
  answers.sent(0.0, start);
  answers.said("", start + milliseconds(10));
  answers.said(kAnother, start + milliseconds(20));
  EXPECT_FALSE(answers.refusal().has_value()) << "it may have stopped just now";
  EXPECT_EQ(answers.whyNone(), kAnother);
  answers.said("", start + milliseconds(780));
  answers.said(kAnother, start + milliseconds(800));
  EXPECT_THAT(answers.refusal(), Optional(std::string(kAnother)));
}

TEST_F(FollowAnswersTest, SomebodyElseWhoIsRefusedIsNoRefusalOfOurs) {
  answers.sent(0.0, start);
  answers.came(answerTo(0.0), start + milliseconds(10));
  answers.said(kAnother, start + milliseconds(800));
  EXPECT_FALSE(answers.refusal().has_value());
  FollowAnswers touching_nothing("");
  touching_nothing.sent(0.0, start);
  touching_nothing.said(kTooLittle, start + milliseconds(20));
  touching_nothing.said(kAnother, start + milliseconds(2500));
  EXPECT_FALSE(touching_nothing.refusal().has_value());
}

TEST_F(FollowAnswersTest, WhatWasSaidBeforeIsOfSomebodyBefore) {
  FollowAnswers after(kMillimetres);
  after.said(kMillimetres, start);
  after.sent(0.0, start);
  after.said(kMillimetres, start + milliseconds(10));  // it was on its way
  EXPECT_FALSE(after.refusal().has_value());
  EXPECT_EQ(after.whyNone(), kMillimetres) << "as far as it is known";
  after.said("", start + milliseconds(20));
  after.said(kMillimetres, start + milliseconds(30));
  EXPECT_THAT(after.refusal(), Optional(std::string(kMillimetres)));
}

TEST_F(FollowAnswersTest, CountsWhatWasAnsweredAndHowLate) {
  for (int k = 0; k < 4; ++k) {
    answers.sent(0.1 * k, start);
    answers.came(answerTo(0.1 * k), start + milliseconds(10 * (k + 1)));
  }
  answers.came(answerTo(7.0), start);
  EXPECT_EQ(answers.count(), 4u);
  EXPECT_NEAR(answers.latency(0.5), 20.0, 1e-9);
  EXPECT_EQ(answers.largestStep(), 0.0);
}

}  // namespace
}  // namespace handgraft::client
