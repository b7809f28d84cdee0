// Whether two patches can be held as far apart as they lie: a pair of tongs, in closed form.

#include "core/optimize/reach.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/io/problem_file.h"
#include "core/optimize/solver.h"

#include "tests/support/shared_data.h"

namespace handgraft::optimize {
namespace {

constexpr double kLeg = 0.1;     // m
constexpr double kNarrow = 0.3;  // rad between the legs
constexpr double kWide = 1.2;

/// Two legs from one hinge, one fixed, whose tips shall meet two points so far apart.
PoseProblem tongs(double apart_m) {
  hand::Joint joint;
  joint.name = "hinge";
  joint.type = hand::JointType::kRevolute;
  joint.parent_link = "root";
  joint.child_link = "leg";
  joint.axis_J = Eigen::Vector3d::UnitZ();
  joint.lower = kNarrow;
  joint.upper = kWide;
  PoseProblem problem = makeProblem(std::make_shared<const hand::HandModel>(
      "tongs", std::vector<hand::Link>{{"root", {}, {}}, {"leg", {}, {}}},
      std::vector<hand::Joint>{joint}));
  for (int patch = 0; patch < 2; ++patch) {
    PointPair pair;
    pair.link = patch;
    pair.patch = patch + 4;
    pair.p_L = {kLeg, 0.0, 0.0};
    pair.n_L = Eigen::Vector3d::UnitZ();
    pair.p_W = {1.0, 2.0, 3.0 + patch * apart_m};
    pair.n_W = Eigen::Vector3d::UnitX();
    problem.pairs.push_back(pair);
  }
  return problem;
}

double tipsApart(double angle) {
  return 2.0 * kLeg * std::sin(0.5 * angle);
}

TEST(SpanMisfit, IsNoneWithinTheRange) {
  for (const double apart : {tipsApart(kNarrow), tipsApart(0.8), tipsApart(kWide)})
    EXPECT_TRUE(findSpanMisfits(tongs(apart), 1e-4).empty()) << apart;
}

TEST(SpanMisfit, TellsATooSmallHandAndByHowMuch) {
  const auto misfits = findSpanMisfits(tongs(tipsApart(kWide) + 0.02));
  ASSERT_EQ(misfits.size(), 1U);
  EXPECT_EQ(misfits[0].patch_a, 4);
  EXPECT_EQ(misfits[0].patch_b, 5);
  EXPECT_NEAR(misfits[0].lack(), 0.02, 1e-5);
  EXPECT_NEAR(misfits[0].hand_m, tipsApart(kWide), 1e-5);
}

TEST(SpanMisfit, TellsATooLargeHandAndByHowMuch) {
  const auto misfits = findSpanMisfits(tongs(tipsApart(kNarrow) - 0.015));
  ASSERT_EQ(misfits.size(), 1U);
  EXPECT_NEAR(misfits[0].lack(), -0.015, 1e-5);
}

TEST(SpanMisfit, ForgivesWhatCountsAsReached) {
  EXPECT_TRUE(findSpanMisfits(tongs(tipsApart(kWide) + 0.011)).empty());
}

TEST(SpanMisfit, RestsOnTheLimits) {
  PoseProblem problem = tongs(tipsApart(kWide) + 0.02);
  problem.upper[0] = 2.0;
  EXPECT_TRUE(findSpanMisfits(problem).empty());
}

TEST(SpanMisfit, LeavesPatchesOutThatAreSwitchedOff) {
  PoseProblem problem = tongs(tipsApart(kWide) + 0.02);
  problem.pairs[0].weight = 0.0;
  EXPECT_TRUE(findSpanMisfits(problem).empty());
}

TEST(SpanMisfit, IsNeverToldOfPatchesThatARealGraspReaches) {
  HANDGRAFT_NEEDS_SHARED_DATA("problems");
  for (const char* name : {"dexycb_cracker_box_g0_fav", "dexycb_mug_g0_fav"}) {
    PoseProblem problem =
        io::readProblem(test::sharedData("problems/" + std::string(name) + ".json"));
    for (PointPair& pair : problem.pairs)
      pair.patch = pair.link;
    EXPECT_TRUE(findSpanMisfits(problem).empty()) << name;
  }
}

}  // namespace
}  // namespace handgraft::optimize
