// The emergency stop, and what leads out of it.

#include <gtest/gtest.h>

#include "hardware/safety/governor.h"

#include "tests/hardware/safety/governor_rig.h"

namespace handgraft::safety {
namespace {

using namespace test;
using State = GovernorState;

// === Emergency stop

TEST(Governor, BrakesWithinTheLimitsThenCutsPowerOnAnEmergencyStop) {
  Rig rig;
  rig.armUp();
  rig.offer({1.0, 1.0});
  rig.follow(20);
  rig.governor.estop();
  EXPECT_EQ(rig.state(), State::kEStop);
  int steps = 0;
  double before = rig.position[0];
  while (rig.tick() == Power::kOn && steps < 100) {
    EXPECT_GE(rig.position[0], before) << "it does not turn back";
    before = rig.position[0];
    ++steps;
  }
  EXPECT_GE(steps, 2);
  EXPECT_LE(steps, 5) << "1 rad/s at 50 rad/s^2, and the average of 2";
  EXPECT_EQ(rig.power, Power::kOff);
}

TEST(Governor, CutsAtOnceWhenItsHandIsToBeCut) {
  GovernorOptions options = quickOptions();
  options.stop_mode = StopMode::kCut;
  Rig rig(options);
  rig.armUp();
  rig.offer({1.0, 1.0});
  rig.follow(20);
  rig.governor.estop();
  EXPECT_EQ(rig.tick(), Power::kCut) << "the next order";
  EXPECT_TRUE(rig.sent.empty());
  EXPECT_EQ(rig.tick(), Power::kCut) << "again, in case that one was lost";
}

TEST(Governor, AnEmergencyStopOverridesEveryStateAndIsLeftByResetAlone) {
  for (int before = 0; before < 5; ++before) {
    Rig rig;
    if (before == 0) rig.connected = false;
    if (before >= 2) rig.armUp();
    if (before == 3) rig.tick(5);
    if (before == 4) rig.fault_code = 1;
    rig.tick();
    rig.governor.estop();
    rig.fault_code = 0;
    rig.connected = true;
    rig.follow(100);
    EXPECT_EQ(rig.state(), State::kEStop);
    EXPECT_EQ(rig.arm(), Refusal::kEStop);
    rig.governor.disarm();
    rig.follow(5);
    EXPECT_EQ(rig.state(), State::kEStop);
    EXPECT_NE(rig.power, Power::kOn);
    EXPECT_EQ(rig.governor.reset(), Refusal::kNone);
    rig.follow(5);
    EXPECT_EQ(rig.state(), State::kIdle) << "from state " << before;
    EXPECT_EQ(rig.power, Power::kOff);
  }
}

TEST(Governor, RefusesAResetWhileTheHandStillBrakes) {
  Rig rig;
  rig.armUp();
  rig.offer({1.0, 1.0});
  rig.follow(20);
  rig.governor.estop();
  rig.tick();
  EXPECT_EQ(rig.governor.reset(), Refusal::kMotorsOn);
}

TEST(Governor, ASecondEmergencyStopUndoesAResetUnderWay) {
  Rig rig;
  rig.follow(1);
  rig.governor.estop();
  rig.follow(1);
  EXPECT_EQ(rig.governor.reset(), Refusal::kNone);
  rig.governor.estop();
  rig.follow(5);
  EXPECT_EQ(rig.state(), State::kEStop);
}

TEST(Governor, CutsOnAnEmergencyStopOfAHandThatCannotBeHeard) {
  Rig rig;
  rig.armUp();
  rig.connected = false;
  rig.tick();
  rig.governor.estop();
  EXPECT_EQ(rig.tick(), Power::kCut);
}

TEST(Governor, HasNothingToResetWhenNothingIsLatched) {
  Rig rig;
  rig.armUp();
  EXPECT_EQ(rig.governor.reset(), Refusal::kNothingToReset);
  EXPECT_EQ(rig.state(), State::kArmed);
}

}  // namespace
}  // namespace handgraft::safety
