#include "hardware/tendon/tendon_hand.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "tests/hardware/tendon/hands.h"

namespace handgraft::tendon {
namespace {

using namespace test;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// The problems of `hand` after `spoil`, on one line.
template <class Spoil>
std::string problemsAfter(TendonHand hand, Spoil spoil) {
  spoil(hand);
  std::string all;
  for (const std::string& problem : problemsOf(hand))
    all += problem + "; ";
  return all;
}

#define EXPECT_PROBLEM(hand, spoil, text)        \
  EXPECT_NE(problemsAfter(hand,                  \
                          [](TendonHand& h) {    \
                            spoil;               \
                          })                     \
                .find(text),                     \
            std::string::npos)                   \
      << problemsAfter(hand, [](TendonHand& h) { \
           spoil;                                \
         })

TEST(TendonHand, HasNothingToObjectToInSoundHands) {
  for (const TendonHand& hand : {workedFinger(), coupledHand(), antagonists()})
    EXPECT_EQ(problemsAfter(hand, [](TendonHand&) {}), "");
}

TEST(TendonHand, NamesNumbersOutOfRange) {
  EXPECT_PROBLEM(workedFinger(), h.joints[0].range = (Range{1, 1}), "'mcp': range [1, 1]");
  EXPECT_PROBLEM(workedFinger(), h.joints[0].range.upper = HUGE_VAL, "'mcp': range");
  EXPECT_PROBLEM(workedFinger(), h.joints[2].stiffness = kNaN, "'dip': stiffness nan");
  EXPECT_PROBLEM(workedFinger(), h.joints[2].stiffness = -1, "'dip': stiffness -1");
  EXPECT_PROBLEM(workedFinger(), h.joints[2].rest = kNaN, "'dip': rest nan");
  EXPECT_PROBLEM(workedFinger(), h.tendons[0].spool.growth_m = -1, "spool growth -1");
  EXPECT_PROBLEM(workedFinger(), h.tendons[0].stiffness = 0, "'flexor': stiffness 0");
  EXPECT_PROBLEM(workedFinger(), h.tendons[0].pretension = 100, "pretension 100 N is not in");
  EXPECT_PROBLEM(workedFinger(), h.tendons[0].largest_tension = 0, "largest tension 0");
}

TEST(TendonHand, NamesWhatIsMissingOrTwice) {
  EXPECT_PROBLEM(workedFinger(), h.joints.clear(), "needs joints");
  EXPECT_PROBLEM(workedFinger(), h.tendons.clear(), "needs tendons");
  EXPECT_PROBLEM(workedFinger(), h.joints[1].name = "mcp", "'mcp' is empty or twice");
  EXPECT_PROBLEM(workedFinger(), h.tendons[0].name = "", "'' is empty or twice");
  EXPECT_PROBLEM(workedFinger(), h.tendons[0].crossings.pop_back(),
                 "'dip' is moved by no tendon");
  EXPECT_PROBLEM(workedFinger(), h.tendons[0].crossings[1].joint = 0, "crossed twice");
  EXPECT_PROBLEM(workedFinger(), h.tendons[0].crossings[1].joint = 9, "does not exist");
  EXPECT_PROBLEM(workedFinger(), h.joints[1].stiffness = 0, "either all joints");
}

TEST(TendonHand, ObjectsToArmsThatVanishOrChangeSign) {
  EXPECT_PROBLEM(workedFinger(),
                 h.tendons[0].crossings[0].extension = Extension::constantArm(0),
                 "must keep its sign");
  EXPECT_PROBLEM(workedFinger(),
                 h.tendons[0].crossings[0].extension = Extension::quadratic(0.001, -0.002),
                 "must keep its sign");
}

TEST(TendonHand, ObjectsToArmsThatOutgrowTheirSprings) {
  // 100 N x 4 mm/rad of growth are 0.4 Nm/rad, more than the spring's 0.3.
  EXPECT_PROBLEM(workedFinger(),
                 h.tendons[0].crossings[0].extension = Extension::quadratic(0.009, 0.004),
                 "by which arms grow");
}

TEST(TendonHand, ObjectsToTensionsThatDoNotCloseTheHand) {
  EXPECT_PROBLEM(workedFinger(), h.tendons[0].largest_tension = 20, "20 N pull it in by");
}

TEST(TendonHand, ObjectsToTendonsThatLeaveJointsUndetermined) {
  EXPECT_PROBLEM(antagonists(), h.tendons.resize(1), "determine 1 of 2 joints");
}

TEST(TendonHand, ObjectsToTendonsThatCannotAllBeTaut) {
  EXPECT_PROBLEM(antagonists(), h.tendons.resize(2), "cannot all be taut");
  EXPECT_PROBLEM(antagonists(),
                 h.tendons[0].crossings[0].extension = Extension::constantArm(-0.01),
                 "cannot all be taut");
  TendonHand loops = antagonists();
  loops.tendons.resize(2);
  for (Tendon& tendon : loops.tendons)
    tendon.closed_loop = true;
  EXPECT_EQ(problemsAfter(loops, [](TendonHand&) {}), "") << "a loop pushes, too";
}

TEST(TendonHand, ObjectsToVaryingArmsWithoutSprings) {
  EXPECT_PROBLEM(antagonists(),
                 h.tendons[0].crossings[0].extension = Extension::quadratic(0.01, 1e-4),
                 "must be constant");
}

TEST(TendonHand, ObjectsToPayingOutMoreThanTheDrumHolds) {
  EXPECT_PROBLEM(antagonists(), h.tendons[0].spool = (Spool{0.001, 0.0005}), "must pay out");
}

}  // namespace
}  // namespace handgraft::tendon
