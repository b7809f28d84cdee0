// What all devices promise, in virtual time.

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"

#include "tests/hardware/emulators/rig.h"

namespace handgraft::devices {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using test::Rig;
using test::RigKind;

constexpr milliseconds kPeriod(10);

class EveryDevice : public ::testing::TestWithParam<RigKind> {
 protected:
  EveryDevice() : rig(test::makeRig(GetParam())), state(rig->count()) {}

  Device& device() { return rig->device(); }

  /// One period of a bridge that moves to `targets`.
  bool cycle(const std::vector<double>& targets) {
    const bool is_healthy = device().read(state) && device().write(targets);
    rig->wire().pass(kPeriod);
    return is_healthy;
  }

  bool cycle(const std::vector<double>& targets, int count) {
    for (int i = 0; i < count; ++i) {
      if (!cycle(targets)) return false;
    }
    return true;
  }

  void armed() {
    device().open();
    device().arm();
  }

  void expectStillFor(Duration time) {
    const std::vector<double> before = rig->angles();
    rig->wire().pass(time);
    EXPECT_EQ(rig->angles(), before);
  }

  std::string fault() { return describe(device().fault()); }

  std::unique_ptr<Rig> rig;
  DeviceState state;
};

TEST_P(EveryDevice, OpensWithItsMotorsOff) {
  rig->leaveStaleGoal();
  device().open();
  EXPECT_FALSE(rig->isPowered());
  EXPECT_FALSE(device().isArmed());
  EXPECT_FALSE(device().fault()) << fault();
  expectStillFor(seconds(1));
  EXPECT_TRUE(device().read(state));
  for (std::size_t i = 0; i < rig->count(); ++i)
    EXPECT_NEAR(state.position[i], rig->angle(i), rig->unit());
}

TEST_P(EveryDevice, ArmsWithoutMoving) {
  rig->leaveStaleGoal();
  device().open();
  const std::vector<double> before = rig->angles();
  device().arm();
  EXPECT_TRUE(rig->isPowered());
  EXPECT_TRUE(device().isArmed());
  rig->wire().pass(milliseconds(50));
  EXPECT_THAT(rig->angles(), ::testing::Pointwise(::testing::DoubleNear(rig->unit()), before));
}

TEST_P(EveryDevice, MovesWhereItIsToldAndReadsBackWithinOneUnit) {
  armed();
  for (const double share : {0.7, 0.31, 0.9}) {
    const std::vector<double> targets = rig->between(share);
    ASSERT_TRUE(cycle(targets, 400)) << fault();
    ASSERT_TRUE(device().read(state));
    for (std::size_t i = 0; i < rig->count(); ++i) {
      EXPECT_NEAR(rig->angle(i), targets[i], rig->unit());
      EXPECT_NEAR(state.position[i], targets[i], rig->unit());
      EXPECT_EQ(state.velocity[i], 0.0);
    }
  }
}

TEST_P(EveryDevice, RoundsInwardsAtItsLimits) {
  armed();
  for (const double share : {0.0, 1.0}) {
    ASSERT_TRUE(cycle(rig->between(share), 700)) << fault();
    for (std::size_t i = 0; i < rig->count(); ++i) {
      EXPECT_GE(rig->angle(i), rig->lower(i)) << i;
      EXPECT_LE(rig->angle(i), rig->upper(i)) << i;
      EXPECT_NEAR(rig->angle(i), rig->between(share)[i], rig->unit()) << i;
    }
  }
}

TEST_P(EveryDevice, MeasuresVelocityInItsDirection) {
  armed();
  ASSERT_TRUE(cycle(rig->between(0.0), 700)) << fault();
  ASSERT_TRUE(cycle(rig->between(1.0), 10)) << fault();
  const std::vector<double> before = rig->angles();
  rig->wire().pass(kPeriod);
  const std::vector<double> after = rig->angles();
  ASSERT_TRUE(device().read(state));
  for (std::size_t i = 0; i < rig->count(); ++i) {
    const double velocity = (after[i] - before[i]) / test::secondsOf(kPeriod);
    EXPECT_GT(velocity, 0.5) << i;
    EXPECT_NEAR(state.velocity[i], velocity, 0.03 * velocity) << i;
  }
}

TEST_P(EveryDevice, StopsByItselfWhenTheDriverDies) {
  if (rig->watchdog() == Duration::zero())
    GTEST_SKIP() << test::nameOf(GetParam()) << " has no watchdog";
  armed();
  ASSERT_TRUE(cycle(rig->between(0.0), 700)) << fault();
  ASSERT_TRUE(cycle(rig->between(1.0), 5)) << fault();
  rig->wire().pass(rig->watchdog() + milliseconds(30));
  EXPECT_FALSE(rig->isPowered());
  expectStillFor(seconds(10));
  for (std::size_t i = 0; i < rig->count(); ++i)
    EXPECT_LT(rig->angle(i), rig->upper(i) - 0.1) << "it had arrived before it stopped";

  // A driver that comes back does not move it on.
  for (int i = 0; i < 20; ++i)
    cycle(rig->between(1.0));
  EXPECT_EQ(device().fault().kind, rig->watchdogFault()) << fault();
  EXPECT_FALSE(device().isArmed());
  expectStillFor(seconds(1));
  device().reset();
  EXPECT_FALSE(rig->isPowered());
  device().arm();
  EXPECT_TRUE(cycle(rig->between(0.5), 700)) << fault();
  EXPECT_NEAR(rig->angle(0), rig->between(0.5)[0], rig->unit());
}

TEST_P(EveryDevice, BearsBadBytes) {
  armed();
  test::Ailments& ailments = rig->emulated().ailments;
  // A line of SLCAN has no checksum: wrong digits cannot be told from right ones.
  const bool has_checksum = GetParam() == RigKind::kDynamixel ||
                            GetParam() == RigKind::kAbilityHand ||
                            GetParam() == RigKind::kLines;
  ailments.flip_rate = has_checksum ? 0.02 : 0.0;
  ailments.drop_rate = 0.01;
  ailments.garbage_rate = 0.05;
  ASSERT_TRUE(cycle(rig->between(0.8), 700)) << fault();
  ailments = {};
  ASSERT_TRUE(cycle(rig->between(0.8), 5)) << fault();
  for (std::size_t i = 0; i < rig->count(); ++i)
    EXPECT_NEAR(state.position[i], rig->between(0.8)[i], rig->unit());
  const DeviceCounters counters = device().counters();
  EXPECT_GT(counters.frames, 600u);
  EXPECT_GT(counters.damaged + counters.garbage_bytes, 0u);
  EXPECT_GT(counters.missed, 0u);
}

TEST_P(EveryDevice, BearsRepeatedAnswers) {
  armed();
  rig->emulated().ailments.repeats = true;
  EXPECT_TRUE(cycle(rig->between(0.8), 400)) << fault();
  EXPECT_NEAR(rig->angle(0), rig->between(0.8)[0], rig->unit());
}

TEST_P(EveryDevice, HardwareErrorIsLatchedUntilItsCauseIsGone) {
  if (GetParam() == RigKind::kAllegro)
    GTEST_SKIP() << test::nameOf(GetParam()) << " tells no errors";
  armed();
  ASSERT_TRUE(cycle(rig->between(0.0), 700)) << fault();
  ASSERT_TRUE(cycle(rig->between(1.0), 5)) << fault();
  rig->breakDown();
  cycle(rig->between(1.0), 20);
  const Fault::Kind expected =
      GetParam() == RigKind::kAbilityHand ? Fault::Kind::kHot : Fault::Kind::kHardware;
  EXPECT_EQ(device().fault().kind, expected) << fault();
  EXPECT_EQ(device().fault().motor, 1);
  EXPECT_FALSE(rig->isPowered());
  EXPECT_FALSE(device().write(rig->between(1.0)));
  EXPECT_THROW(device().arm(), DeviceError);
  expectStillFor(seconds(1));
  // The Ability Hand only says so while it obeys: armed again, it says so again.
  if (GetParam() != RigKind::kAbilityHand) {
    EXPECT_THROW(device().reset(), DeviceError);
    EXPECT_TRUE(device().fault());
  }
  rig->heal();
  device().reset();
  EXPECT_FALSE(device().fault()) << fault();
  EXPECT_FALSE(rig->isPowered());
  EXPECT_FALSE(device().write(rig->between(1.0))) << "not armed";
  device().arm();
  EXPECT_TRUE(cycle(rig->between(0.5), 400)) << fault();
}

TEST_P(EveryDevice, SilenceIsAFaultAndTheMotorsAreCutOff) {
  armed();
  ASSERT_TRUE(cycle(rig->between(0.6), 5)) << fault();
  rig->emulated().ailments.is_mute = true;
  for (int i = 0; i < 50 && !device().fault(); ++i)
    cycle(rig->between(0.6));
  EXPECT_EQ(device().fault().kind, Fault::Kind::kSilent) << fault();
  EXPECT_FALSE(rig->isPowered());
}

TEST_P(EveryDevice, LosingTheWireIsAFaultInTheSameCycle) {
  armed();
  ASSERT_TRUE(cycle(rig->between(0.6), 5)) << fault();
  rig->wire().unplug();
  EXPECT_FALSE(device().read(state));
  EXPECT_EQ(device().fault().kind, Fault::Kind::kWire);
  EXPECT_THROW(device().reset(), TransportError);
  rig->wire().pass(seconds(1));
  const bool has_watchdog = rig->watchdog() > Duration::zero();
  EXPECT_EQ(rig->isPowered(), !has_watchdog) << "by its own watchdog";

  rig->wire().plug();
  cycle(rig->between(0.6), 10);
  EXPECT_EQ(rig->isPowered(), !has_watchdog) << "moves by itself when it comes back";
  device().reset();
  EXPECT_FALSE(device().isArmed());
  EXPECT_FALSE(device().write(rig->between(0.6)));
  EXPECT_FALSE(rig->isPowered());
  device().arm();
  EXPECT_TRUE(cycle(rig->between(0.6), 5)) << fault();
}

TEST_P(EveryDevice, LosingTheWireWhileWritingIsAFault) {
  armed();
  ASSERT_TRUE(device().read(state));
  rig->wire().unplug();
  EXPECT_FALSE(device().write(rig->between(0.6)));
  EXPECT_EQ(device().fault().kind, Fault::Kind::kWire);
}

TEST_P(EveryDevice, DisarmsAndSaysSo) {
  armed();
  ASSERT_TRUE(cycle(rig->between(0.6), 5)) << fault();
  EXPECT_TRUE(device().disarm());
  EXPECT_FALSE(device().isArmed());
  EXPECT_FALSE(rig->isPowered());
  EXPECT_FALSE(device().write(rig->between(0.6)));
  expectStillFor(seconds(1));
  EXPECT_TRUE(device().read(state)) << fault();
}

TEST_P(EveryDevice, DisarmingAMuteDeviceIsAFault) {
  armed();
  rig->emulated().ailments.is_mute = true;
  EXPECT_FALSE(device().disarm());
  EXPECT_TRUE(device().fault());
  EXPECT_FALSE(rig->isPowered()) << "it hears, all the same";
}

TEST_P(EveryDevice, StopIsTheNextThingOnTheWire) {
  armed();
  ASSERT_TRUE(cycle(rig->between(0.6), 5)) << fault();
  test::takeSent(rig->wire());
  device().stop();
  EXPECT_FALSE(rig->isPowered());
  EXPECT_EQ(test::takeSent(rig->wire()).size(), rig->stopMessages());
  EXPECT_FALSE(device().isArmed());
  expectStillFor(seconds(1));
}

TEST_P(EveryDevice, ATargetThatIsNoNumberIsNeverSent) {
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    rig = test::makeRig(GetParam());
    armed();
    ASSERT_TRUE(device().read(state));
    std::vector<double> targets = rig->between(0.6);
    targets.back() = bad;
    EXPECT_FALSE(device().write(targets));
    EXPECT_EQ(device().fault().kind, Fault::Kind::kBadTarget);
    EXPECT_FALSE(rig->isPowered());
    expectStillFor(seconds(1));
  }
}

TEST_P(EveryDevice, TargetsOfAnySizeDoNoHarm) {
  armed();
  for (const double huge : {1e300, -1e300, 1e9, -1e9}) {
    static_cast<void>(device().read(state));
    static_cast<void>(device().write(std::vector<double>(rig->count(), huge)));
  }
  EXPECT_FALSE(device().fault()) << fault();
}

TEST_P(EveryDevice, RefusesToArmBeforeItIsOpen) {
  EXPECT_THROW(device().arm(), DeviceError);
  EXPECT_FALSE(device().read(state));
  EXPECT_FALSE(device().write(rig->between(0.5)));
  device().stop();  // nothing happens
}

TEST_P(EveryDevice, OpeningAMuteOrMissingDeviceFails) {
  rig->wire().unplug();
  EXPECT_THROW(device().open(), TransportError);
  rig->wire().plug();
  rig->emulated().ailments.is_mute = true;
  EXPECT_THROW(device().open(), DeviceError);
}

TEST_P(EveryDevice, WrongCountsAreOurOwnMistake) {
  armed();
  EXPECT_THROW(static_cast<void>(device().write(std::vector<double>(1))), BrokenContract);
  DeviceState small(1);
  EXPECT_THROW(static_cast<void>(device().read(small)), BrokenContract);
}

TEST_P(EveryDevice, StateCarriesTheTimeOfItsReading) {
  device().open();
  ASSERT_TRUE(device().read(state));
  const TimePoint first = state.time;
  EXPECT_LE(first, rig->wire().clock()());
  rig->wire().pass(kPeriod);
  ASSERT_TRUE(device().read(state));
  EXPECT_EQ(state.time - first, kPeriod);
}

INSTANTIATE_TEST_SUITE_P(All,
                         EveryDevice,
                         ::testing::Values(RigKind::kDynamixel,
                                           RigKind::kAbilityHand,
                                           RigKind::kODrive06,
                                           RigKind::kODrive05,
                                           RigKind::kInspire,
                                           RigKind::kAllegro,
                                           RigKind::kLines),
                         [](const auto& told) {
                           return test::nameOf(told.param);
                         });

}  // namespace
}  // namespace handgraft::devices
