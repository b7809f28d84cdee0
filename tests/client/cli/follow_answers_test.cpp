// What `motion follow` makes of what a session says while frames are sent.
#include "client/cli/commands/follow_answers.h"

#include <cmath>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace handgraft::client {
namespace {

using std::chrono::milliseconds;
using testing::Optional;

v1::FollowState stateOf(v1::FollowVerdict verdict, const std::string& text) {
  v1::FollowState state;
  state.verdict(verdict);
  state.text(text);
  return state;
}

const v1::FollowState nothing_said;
const v1::FollowState millimetres = stateOf(v1::FOLLOW_REFUSED, "demonstrator: millimetres?");
const v1::FollowState another = stateOf(v1::FOLLOW_ANOTHER, "demonstrator: another one");
const v1::FollowState too_little = stateOf(v1::FOLLOW_WAITS, "demonstrator: touches with 1");

v1::PoseSolution answerTo(double time_s, std::vector<double> joints = {0.5}) {
  v1::PoseSolution solution;
  solution.time_s().push_back(time_s);
  solution.joint_positions(std::move(joints));
  return solution;
}

class FollowAnswersTest : public testing::Test {
 protected:
  FollowAnswers::Clock::time_point start = FollowAnswers::Clock::now();
  FollowAnswers answers{nothing_said};
};

TEST_F(FollowAnswersTest, TheFirstRefusalIsKept) {
  answers.sent(0.0, start);
  answers.said(millimetres, start + milliseconds(20));
  answers.said(another, start + milliseconds(40));
  EXPECT_THAT(answers.refusal(), Optional(millimetres.text()));
}

TEST_F(FollowAnswersTest, TouchingTooLittleIsNoRefusalAndTellsWhyNothingCame) {
  answers.sent(0.0, start);
  answers.said(too_little, start + milliseconds(20));
  EXPECT_FALSE(answers.refusal().has_value());
  EXPECT_EQ(answers.whyNone(), too_little.text());
  EXPECT_TRUE(std::isnan(answers.latency(0.5)));
}

TEST_F(FollowAnswersTest, WhatTheHandWaitedForIsToldAlsoOnceItHasAPose) {
  EXPECT_FALSE(answers.waiting());
  answers.sent(0.0, start);
  answers.said(too_little, start + milliseconds(10));
  answers.said(nothing_said, start + milliseconds(20));
  answers.sent(0.1, start);
  answers.came(answerTo(0.1), start + milliseconds(30));
  EXPECT_THAT(answers.waiting(), Optional(too_little.text()));
}

TEST_F(FollowAnswersTest, SomebodyElseWhoIsFollowedRefusesUs) {
  answers.sent(0.0, start);
  answers.said(nothing_said, start + milliseconds(10));
  answers.said(another, start + milliseconds(20));
  EXPECT_FALSE(answers.refusal().has_value()) << "it may have stopped just now";
  EXPECT_EQ(answers.whyNone(), another.text());
  answers.said(nothing_said, start + milliseconds(780));
  answers.said(another, start + milliseconds(800));
  EXPECT_THAT(answers.refusal(), Optional(another.text()));
}

TEST_F(FollowAnswersTest, SomebodyElseWhoIsRefusedIsNoRefusalOfOurs) {
  answers.sent(0.0, start);
  answers.came(answerTo(0.0), start + milliseconds(10));
  answers.said(another, start + milliseconds(800));
  EXPECT_FALSE(answers.refusal().has_value());
  FollowAnswers touching_nothing(nothing_said);
  touching_nothing.sent(0.0, start);
  touching_nothing.said(too_little, start + milliseconds(20));
  touching_nothing.said(another, start + milliseconds(2500));
  EXPECT_FALSE(touching_nothing.refusal().has_value());
}

TEST_F(FollowAnswersTest, WhatWasSaidBeforeIsOfSomebodyBefore) {
  FollowAnswers after(millimetres);
  after.said(millimetres, start);
  after.sent(0.0, start);
  after.said(millimetres, start + milliseconds(10));  // it was on its way
  EXPECT_FALSE(after.refusal().has_value());
  EXPECT_EQ(after.whyNone(), millimetres.text()) << "as far as it is known";
  after.said(nothing_said, start + milliseconds(20));
  after.said(millimetres, start + milliseconds(30));
  EXPECT_THAT(after.refusal(), Optional(millimetres.text()));
}

TEST_F(FollowAnswersTest, CountsWhatWasAnsweredAndHowLate) {
  for (int k = 0; k < 4; ++k) {
    answers.sent(0.1 * k, start);
    answers.came(answerTo(0.1 * k), start + milliseconds(10 * (k + 1)));
  }
  answers.came(answerTo(7.0), start);
  EXPECT_EQ(answers.count(), 4u);
  EXPECT_NEAR(answers.latency(0.5), 20.0, 1e-9);
  EXPECT_EQ(answers.largestStep().size, 0.0);
}

TEST_F(FollowAnswersTest, GoesOnPastAGlitchButNotPastRefusalsAlone) {
  const v1::FollowState backwards = stateOf(v1::FOLLOW_REFUSED, "demonstrator: backwards");
  FollowAnswers of_glitches(nothing_said);
  of_glitches.sent(0.0, start);
  of_glitches.said(millimetres, start + milliseconds(10));
  EXPECT_FALSE(of_glitches.isHopeless(start + milliseconds(500)));
  EXPECT_TRUE(of_glitches.isHopeless(start + milliseconds(1000)));
  of_glitches.came(answerTo(0.0), start + milliseconds(1010));
  EXPECT_FALSE(of_glitches.isHopeless(start + milliseconds(2000)));
  of_glitches.said(nothing_said, start + milliseconds(1010));
  of_glitches.sent(1.5, start + milliseconds(1500));
  of_glitches.said(millimetres, start + milliseconds(1510));
  of_glitches.said(millimetres, start + milliseconds(1520));
  of_glitches.said(backwards, start + milliseconds(1530));
  EXPECT_EQ(of_glitches.refusals().count, 3);
  EXPECT_EQ(of_glitches.refusals().first_s, 0.0);
  EXPECT_THAT(of_glitches.refusal(), Optional(millimetres.text()));

  FollowAnswers touching_little(nothing_said);
  touching_little.sent(0.0, start);
  touching_little.said(too_little, start + milliseconds(10));
  touching_little.said(millimetres, start + milliseconds(20));
  EXPECT_FALSE(touching_little.isHopeless(start + milliseconds(2000)));

  FollowAnswers beside_another(nothing_said);
  beside_another.sent(0.0, start);
  beside_another.said(another, start + milliseconds(800));
  EXPECT_TRUE(beside_another.isHopeless(start + milliseconds(800)));
}

TEST_F(FollowAnswersTest, TellsWhichJointWentFarthestAndHowFast) {
  const std::pair<double, std::vector<double>> sent[] = {
      {0.0, {0.0, 0.0}}, {0.1, {0.0, 1.0}}, {0.2, {0.1, 1.0}}, {0.25, {0.1, 1.1}}};
  for (const auto& [time_s, joints] : sent) {
    answers.sent(time_s, start);
    answers.came(answerTo(time_s, joints), start);
  }
  EXPECT_EQ(answers.largestStep().size, 1.0);
  EXPECT_EQ(answers.largestStep().joint, 1u);
  EXPECT_EQ(answers.largestStep().time_s, 0.1);
  EXPECT_NEAR(answers.largestSpeed(), 2.0, 1e-6) << "but for the first step";
}

TEST_F(FollowAnswersTest, AStepIsOfAFrameAlsoWhereSomeHadNoAnswer) {
  for (int k = 0; k <= 5; ++k)
    answers.sent(0.1 * k, start);
  const auto at = [](double time_s, double x_m, double joint) {
    v1::PoseSolution solution = answerTo(time_s, {joint});
    solution.X_WH().p_m({x_m, 0.0, 0.0});
    return solution;
  };
  answers.came(at(0.0, 0.0, 0.0), start);
  answers.came(at(0.1, 0.02, 0.1), start);
  answers.came(at(0.5, 0.06, 0.3), start);  // four frames in one
  EXPECT_DOUBLE_EQ(answers.largestStep().size, 0.1);
  EXPECT_DOUBLE_EQ(answers.largestRootStep().size, 0.02);
  EXPECT_DOUBLE_EQ(answers.largestRootStep().time_s, 0.1);
}

}  // namespace
}  // namespace handgraft::client
