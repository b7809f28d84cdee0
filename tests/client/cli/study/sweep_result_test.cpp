// What a sweep's reply becomes: points, table, lines, document.
#include "client/cli/study/sweep_result.h"

#include <array>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/base/error.h"

namespace handgraft::client {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

v1::JointLimit limit(const std::string& joint, v1::LimitSide side) {
  v1::JointLimit one;
  one.joint(joint);
  one.side(side);
  return one;
}

/// Two grasps; of each value the mean distances and the patches reached, of 3.
struct Answer {
  double value;
  double mean_a;
  double mean_b;
  unsigned reached_a;
  unsigned reached_b;
};

SweepResult resultOf(const std::vector<Answer>& answers) {
  SweepResult result;
  result.hand = "hand";
  result.grasps = {{"cup", "sets/cup.json", "cup"}, {"box, red", "sets/box.json", "box"}};
  StudyAxis axis;
  axis.name = "thumb.upper";
  result.units = {"rad"};
  result.reply.joint_names({"thumb", "index"});
  for (const Answer& answer : answers) {
    axis.axis.values().push_back(answer.value);
    for (const unsigned grasp : {0U, 1U}) {
      v1::SweepRow row;
      row.grasp(grasp);
      row.values({answer.value});
      row.mean_mm(grasp == 0 ? answer.mean_a : answer.mean_b);
      row.patch_count(3);
      row.reached_count(grasp == 0 ? answer.reached_a : answer.reached_b);
      row.joint_positions({0.25, -0.5});
      row.joints_at_limit({limit("thumb", v1::LIMIT_UPPER), limit("index", v1::LIMIT_LOWER)});
      result.reply.rows().push_back(row);
    }
  }
  result.axes = {axis};
  return result;
}

TEST(SweepResult, MeansOverGrasps) {
  SweepResult result = resultOf({{0.1, 4.0, 6.0, 2, 3}, {0.2, 1.0, 2.0, 3, 3}});
  result.reply.rows()[1].error("limits cross");
  const std::vector<SweepPoint> points = pointsOf(result);
  ASSERT_EQ(points.size(), 2u);
  EXPECT_EQ(points[0].solved, 1);
  EXPECT_EQ(points[0].mean_mm, 4.0);
  EXPECT_EQ(points[1].mean_mm, 1.5);
  EXPECT_EQ(points[1].worst_mm, 2.0);
  EXPECT_EQ(points[1].reached, 6);
  EXPECT_EQ(bestOf(points), 1u);
}

TEST(SweepResult, TellsTheDeepestOfAPointsGrasps) {
  SweepResult result = resultOf({{0.1, 4.0, 6.0, 2, 3}, {0.2, 1.0, 2.0, 3, 3}});
  result.reply.rows()[2].max_depth_m(0.0012);
  result.reply.rows()[3].max_depth_m(0.0031);
  result.reply.rows()[2].self_depth_m(0.0004);
  const std::vector<SweepPoint> points = pointsOf(result);
  EXPECT_EQ(points[0].deepest_mm, 0.0);
  EXPECT_NEAR(points[1].deepest_mm, 3.1, 1e-12);
  EXPECT_NEAR(points[1].self_mm, 0.4, 1e-12);
  EXPECT_THAT(text::sweep(result),
              testing::AllOf(HasSubstr("inside mm  in itself mm"),
                             testing::ContainsRegex("0.2 +1.50 +2.00 +3.10 +0.40 +6 of 6")));
}

TEST(SweepResult, APointWithoutAllGraspsIsNoBest) {
  SweepResult result = resultOf({{0.1, 0.1, 9.0, 3, 3}, {0.2, 2.0, 2.0, 3, 3}});
  result.reply.rows()[1].error("limits cross");
  EXPECT_EQ(bestOf(pointsOf(result)), 1u);
}

TEST(SweepResult, ReachingAPatchMoreIsBetterThanLyingNearer) {
  const SweepResult result =
      resultOf({{0.1, 1.0, 1.0, 2, 3}, {0.2, 3.0, 3.0, 3, 3}, {0.3, 2.5, 2.5, 3, 3}});
  EXPECT_EQ(bestOf(pointsOf(result)), 2u);
  EXPECT_THAT(text::sweep(result), HasSubstr("best: thumb.upper = 0.3 rad, mean 2.50 mm"));
}

TEST(SweepResult, WhatAHandDropsIsAskedOfItAllTheSame) {
  SweepResult result = resultOf({{0.1, 1.0, 1.0, 2, 2}, {0.2, 1.2, 1.2, 3, 3}});
  for (const std::size_t row : {0U, 1U})
    result.reply.rows()[row].patch_count(2);
  const std::vector<SweepPoint> points = pointsOf(result);
  EXPECT_EQ(points[0].reached, 4);
  EXPECT_EQ(points[0].patches, 6) << "as where none is dropped";
  EXPECT_EQ(bestOf(points), 1u);
  EXPECT_THAT(text::sweep(result), HasSubstr("4 of 6"));
}

// Its poses are all of the wider limit's, too: what is told is how the searches went.
TEST(SweepResult, TellsWhereAWiderLimitComesToLess) {
  const std::vector<Answer> answers = {
      {0.1, 1.0, 1.0, 2, 2}, {0.2, 1.0, 1.0, 3, 3}, {0.3, 1.1, 1.1, 3, 2}};
  SweepResult result = resultOf(answers);
  const auto told =
      HasSubstr("0.3 rad permits all that 0.2 rad does, and its search came to less");
  result.axes[0].axis.property(v1::PROPERTY_SIZE);
  EXPECT_THAT(text::sweep(result), testing::Not(told)) << "of a size nothing follows";
  result.axes[0].axis.property(v1::PROPERTY_UPPER);
  EXPECT_THAT(text::sweep(result), told);
  result.axes[0].axis.property(v1::PROPERTY_LOWER);
  EXPECT_THAT(text::sweep(result),
              HasSubstr("0.1 rad permits all that 0.2 rad does, and its search came to less"));
}

TEST(SweepResult, FindsWhereTheFirstPatchIsLost) {
  // Not in the order of the values, which are 0.1 to 0.5.
  const SweepResult result = resultOf({{0.5, 3, 3, 3, 3},
                                       {0.4, 1, 1, 3, 3},
                                       {0.1, 9, 9, 1, 1},
                                       {0.3, 2, 2, 3, 3},
                                       {0.2, 5, 5, 3, 2}});
  const std::vector<SweepPoint> points = pointsOf(result);
  ASSERT_EQ(bestOf(points), 1u);
  const FirstLoss loss = firstLossOf(points, 1);
  EXPECT_EQ(loss.below, 4u);
  EXPECT_FALSE(loss.above.has_value());
  const std::string text = text::sweep(result);
  EXPECT_THAT(text, HasSubstr("best: thumb.upper = 0.4 rad, mean 1.00 mm"));
  EXPECT_THAT(text, HasSubstr("below it the first patch is lost at thumb.upper = 0.2 rad "
                              "(box, red 2 of 3)"));
}

TEST(SweepResult, LosesNoPatchWhereThereIsNoAnswer) {
  SweepResult result = resultOf({{0.1, 1, 1, 3, 3}, {0.2, 0, 0, 0, 0}, {0.3, 2, 2, 3, 2}});
  result.reply.rows()[2].error("no patch finds a place");
  result.reply.rows()[3].reached_count(3);
  EXPECT_EQ(firstLossOf(pointsOf(result), 0).above, 2u);
  result.reply.rows()[3].reached_count(1);
  EXPECT_EQ(firstLossOf(pointsOf(result), 0).above, 1u) << "the other grasp lost two there";
  EXPECT_THAT(text::sweep(result),
              HasSubstr("above it the first patch is lost at thumb.upper = 0.2 rad (box, red 1 "
                        "of 3)"));
  result.reply.rows()[3].reached_count(3);
  result.reply.rows()[5].reached_count(3);
  EXPECT_THAT(text::sweep(result), HasSubstr("no patch is lost on either side"));
}

TEST(SweepResult, SaysThatNothingIsReachedAnywhere) {
  const SweepResult result = resultOf({{0.1, 14, 13, 0, 0}, {0.2, 12, 11, 0, 0}});
  EXPECT_THAT(text::sweep(result), testing::AllOf(HasSubstr("no patch is reached at any value"),
                                                  testing::Not(HasSubstr("no patch is lost"))));
}

TEST(SweepResult, TellsWhatIsAsGoodAsTheBest) {
  const SweepResult result = resultOf({{0.1, 1.0, 1.0, 3, 3},
                                       {0.2, 1.002, 1.004, 3, 3},
                                       {0.3, 1.0, 1.0, 3, 2},
                                       {0.4, 1.1, 1.1, 3, 3}});
  EXPECT_THAT(asGoodAs(0, pointsOf(result)), ElementsAre(1u));
  EXPECT_THAT(text::sweep(result), HasSubstr("best: thumb.upper = 0.1 rad, mean 1.00 mm\n"
                                             "as good: thumb.upper = 0.2 rad\n"));

  const SweepResult many = resultOf(std::vector<Answer>(7, {0.5, 1.0, 1.0, 3, 3}));
  EXPECT_THAT(text::sweep(many), HasSubstr("thumb.upper = 0.5 rad; 2 more\n"));

  const SweepResult clear = resultOf({{0.1, 1.0, 1.0, 3, 3}, {0.2, 2.0, 2.0, 3, 3}});
  EXPECT_THAT(text::sweep(clear), testing::Not(HasSubstr("as good")));
}

TEST(SweepResult, WritesATableThatReadsBack) {
  SweepResult result = resultOf({{0.1, 4.0, 6.0, 2, 3}});
  result.reply.rows()[0].max_depth_m(0.0012);
  result.reply.rows()[0].self_depth_m(0.0004);
  result.reply.rows()[1].error("lower, \"above\" upper");
  std::istringstream csv(csvOf(result));
  std::string line;
  std::getline(csv, line);
  EXPECT_EQ(line,
            "grasp,thumb.upper (rad),error,outcome,mean_mm,max_mm,normal_deg,depth_mm,"
            "self_depth_mm,patches,reached,points,objective,distance_m2,normal,prior,"
            "joints_at_limit,solve_ms,thumb,index");
  std::getline(csv, line);
  EXPECT_EQ(
      line,
      "cup,0.1,,converged,4,0,0,1.2,0.4,3,2,0,0,0,0,0,thumb upper;index lower,0,0.25,-0.5");
  std::getline(csv, line);
  EXPECT_EQ(line, "\"box, red\",0.1,\"lower, \"\"above\"\" upper\",,,,,,,,,,,,,,,,,");
  EXPECT_FALSE(std::getline(csv, line));
}

/// A motion beside the grasps, and its patches thumb and ring: of each value in how many of its
/// ten frames these are reached, and both.
void addMotion(SweepResult& result, const std::vector<std::array<unsigned, 3>>& reached) {
  const std::size_t grasps = result.grasps.size();
  for (const StudyGrasp& one : withPatches({"pull", {}, "box", "pull.json"}, {"thumb", "ring"}))
    result.grasps.push_back(one);
  std::vector<v1::SweepRow> rows;
  for (std::size_t i = 0; i < reached.size(); ++i) {
    for (std::size_t g = 0; g < grasps; ++g)
      rows.push_back(result.reply.rows()[grasps * i + g]);
    for (const std::size_t which : {2U, 0U, 1U}) {
      v1::SweepRow row;
      row.grasp(static_cast<std::uint32_t>(rows.size() % result.grasps.size()));
      row.values(result.reply.rows()[grasps * i].values());
      row.mean_mm(2.0);
      row.patch_count(10);
      row.reached_count(reached[i][which]);
      rows.push_back(row);
    }
  }
  result.reply.rows(rows);
}

TEST(SweepResult, AMotionCountsByTheShareOfItsFrames) {
  SweepResult result = resultOf({{0.1, 1, 1, 3, 3}, {0.2, 2, 2, 3, 3}, {0.3, 3, 3, 3, 3}});
  addMotion(result, {{10, 10, 10}, {10, 8, 8}, {10, 3, 2}});
  requireConsistent(result);
  const std::vector<SweepPoint> points = pointsOf(result);
  EXPECT_EQ(points[0].patches, 8);
  EXPECT_EQ(points[0].solved, 3) << "two grasps and a motion";
  EXPECT_NEAR(points[0].mean_mm, (1.0 + 1.0 + 2.0) / 3.0, 1e-12) << "a patch is no grasp";
  EXPECT_NEAR(points[0].reached, 8.0, 1e-12);
  EXPECT_NEAR(points[1].reached, 7.8, 1e-12);
  EXPECT_EQ(firstLossOf(points, 0).above, 2u) << "a fifth of a motion is no patch";
  const std::string text = text::sweep(result);
  EXPECT_THAT(text, HasSubstr("hand: 2 grasps and 1 motion, 15 rows"));
  EXPECT_THAT(text, HasSubstr("7.8 of 8"));
  EXPECT_THAT(text, HasSubstr("3 of 3"));
  EXPECT_THAT(text, HasSubstr("pull: in how many of its frames each patch is reached"));
  EXPECT_THAT(text, testing::ContainsRegex("0\\.3 +20 % +100 % +30 %"));
  EXPECT_THAT(text, HasSubstr("the first patch is lost at thumb.upper = 0.3 rad (pull 2 of 10 "
                              "frames, pull/ring 3 of 10 frames)"));
  EXPECT_THAT(csvOf(result),
              HasSubstr("pull/ring,0.2,,converged,2,0,0,0,0,10,8,0,0,0,0,0,,0,,"));
  const nlohmann::json document = nlohmann::json::parse(json::sweep(result));
  EXPECT_EQ(document.at("grasps").at(2).at("motion"), "pull.json");
  EXPECT_EQ(document.at("grasps").at(4).at("patch"), "ring");
  EXPECT_EQ(document.at("rows").at(14).at("reached_count"), 3);
}

TEST(SweepResult, DrawsAPanelOfEachMotion) {
  SweepResult result = resultOf({{0.1, 1, 1, 3, 3}, {0.2, 2, 2, 3, 3}});
  const render::Image without = pictureOf(result);
  addMotion(result, {{10, 10, 10}, {0, 8, 0}});
  const render::Image with = pictureOf(result);
  EXPECT_NE(with.pixels(), without.pixels());
}

TEST(SweepResult, RefusesPatchesThatAreReachedMoreOftenThanThere) {
  SweepResult result = resultOf({{0.1, 1, 1, 3, 3}});
  addMotion(result, {{11, 10, 10}});
  EXPECT_THROW(requireConsistent(result), TransportError);
}

TEST(SweepResult, TellsAxesInDegrees) {
  SweepResult result = resultOf({{10.0, 4, 6, 2, 3}, {60.0, 1, 2, 3, 3}});
  StudyAxis& axis = result.axes[0];
  axis.axis.property(v1::PROPERTY_UPPER);
  axis.axis.target("thumb");
  v1::JointInfo joint;
  joint.name("thumb");
  joint.kind(v1::JOINT_REVOLUTE);
  joint.upper(1.2);
  v1::HandDescription hand;
  hand.joints({joint});
  result.notes = notesOn(result.axes, hand);
  EXPECT_THAT(text::sweep(result), HasSubstr("note: limits 0 to 60 rad of joint 'thumb'"));
  EXPECT_THAT(nlohmann::json::parse(json::sweep(result)).at("notes"), testing::SizeIs(1));
  axis.axis.values() = {0.2, 0.6};
  EXPECT_THAT(notesOn(result.axes, hand), testing::IsEmpty());
}

TEST(SweepResult, IsOneDocument) {
  const nlohmann::json document =
      nlohmann::json::parse(json::sweep(resultOf({{0.1, 4, 6, 2, 3}, {0.2, 1, 2, 3, 3}})));
  EXPECT_EQ(document.at("format"), "handgraft-sweep/1");
  EXPECT_EQ(document.at("rows").size(), 4u);
  EXPECT_EQ(document.at("best").at("values").at(0), 0.2);
  EXPECT_EQ(document.at("rows").at(3).at("grasp"), "box, red");
}

TEST(SweepResult, RefusesAReplyThatDoesNotFit) {
  SweepResult result = resultOf({{0.1, 4, 6, 2, 3}, {0.2, 1, 2, 3, 3}});
  EXPECT_NO_THROW(requireConsistent(result));
  result.reply.rows()[1].grasp(7);
  EXPECT_THROW(requireConsistent(result), TransportError);
  result = resultOf({{0.1, 4, 6, 2, 3}});
  result.reply.rows().pop_back();
  EXPECT_THROW(requireConsistent(result), TransportError);
}

TEST(SweepResult, DrawsOneAxisOrTwo) {
  SweepResult result = resultOf({{0.1, 4, 6, 2, 3}, {0.2, 1, 2, 3, 3}});
  EXPECT_EQ(pictureOf(result).width(), 1600);
  StudyAxis other;
  other.name = "hand.size";
  other.axis.values({1.0});
  result.axes.push_back(other);
  result.units.emplace_back();
  for (v1::SweepRow& row : result.reply.rows())
    row.values().push_back(1.0);
  EXPECT_EQ(pictureOf(result).width(), 1600);
  result.axes.clear();
  EXPECT_THROW((void)pictureOf(result), InvalidInput);
}

}  // namespace
}  // namespace handgraft::client
