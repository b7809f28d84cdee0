// Devices on pseudo terminals, in real time: what virtual time cannot show.

#include <cmath>

#include <gtest/gtest.h>

#include "core/base/error.h"

#include "tests/hardware/allocation_count.h"
#include "tests/hardware/emulators/rig.h"

namespace handgraft::devices {
namespace {

using std::chrono::milliseconds;
using test::Rig;
using test::RigKind;

class EveryDeviceOnAPty : public ::testing::TestWithParam<RigKind> {
 protected:
  EveryDeviceOnAPty()
      : rig(test::makeRig(GetParam(), test::WireKind::kPty)), state(rig->count()) {}

  Device& device() { return rig->device(); }

  /// Runs until the hand is where it is told to be; false if it does not come there. A busy
  /// machine may let a device wait for too long, which is a fault, and rightly so.
  bool moveTo(const std::vector<double>& targets) {
    for (int i = 0; i < 20000; ++i) {
      if (!device().read(state) || !device().write(targets)) {
        if (device().fault().kind != rig->watchdogFault()) return false;
        device().reset();
        device().arm();
        continue;
      }
      double farthest = 0.0;
      for (std::size_t j = 0; j < targets.size(); ++j)
        farthest = std::max(farthest, std::abs(state.position[j] - targets[j]));
      if (farthest <= rig->unit()) return true;
      rig->wire().pass(milliseconds(1));
    }
    return false;
  }

  std::string fault() { return describe(device().fault()); }

  std::unique_ptr<Rig> rig;
  DeviceState state;
};

TEST_P(EveryDeviceOnAPty, MovesAndReadsBackWithinOneUnit) {
  device().open();
  device().arm();
  for (const double share : {0.6, 0.4}) {
    ASSERT_TRUE(moveTo(rig->between(share))) << fault();
    for (std::size_t i = 0; i < rig->count(); ++i)
      EXPECT_NEAR(rig->angle(i), rig->between(share)[i], rig->unit());
  }
  EXPECT_TRUE(device().disarm());
  EXPECT_FALSE(rig->isPowered());
}

TEST_P(EveryDeviceOnAPty, UnpluggedIsAFaultAndPluggedInAgainStaysDisarmed) {
  device().open();
  device().arm();
  ASSERT_TRUE(moveTo(rig->between(0.55))) << fault();
  rig->wire().unplug();
  EXPECT_FALSE(device().read(state));
  EXPECT_EQ(device().fault().kind, Fault::Kind::kWire) << fault();
  rig->wire().plug();
  EXPECT_FALSE(device().read(state)) << "a fault stays";
  EXPECT_FALSE(device().write(rig->between(0.6)));
  device().reset();
  EXPECT_FALSE(device().isArmed());
  EXPECT_FALSE(rig->isPowered());
  device().arm();
  EXPECT_TRUE(moveTo(rig->between(0.6))) << fault();
}

TEST_P(EveryDeviceOnAPty, StopsByItselfWhenTheDriverDies) {
  device().open();
  device().arm();
  ASSERT_TRUE(moveTo(rig->between(0.5))) << fault();
  for (int i = 0; i < 600 && rig->isPowered(); ++i)
    rig->wire().pass(milliseconds(100));
  EXPECT_FALSE(rig->isPowered());
}

TEST_P(EveryDeviceOnAPty, ReadsAndWritesWithoutAllocating) {
  device().open();
  device().arm();
  const std::vector<double> targets = rig->between(0.5);
  ASSERT_TRUE(moveTo(targets)) << fault();
  const long before = test::allocationCount();
  for (int i = 0; i < 100; ++i) {
    static_cast<void>(device().read(state));
    static_cast<void>(device().write(targets));
  }
  device().stop();
  EXPECT_EQ(test::allocationCount(), before);
  const std::vector<double> another(1);
  EXPECT_EQ(test::allocationCount(), before + 1) << "nothing is counted";
}

INSTANTIATE_TEST_SUITE_P(All,
                         EveryDeviceOnAPty,
                         ::testing::Values(RigKind::kDynamixel,
                                           RigKind::kAbilityHand,
                                           RigKind::kODrive06),
                         [](const auto& told) {
                           return test::nameOf(told.param);
                         });

}  // namespace
}  // namespace handgraft::devices
