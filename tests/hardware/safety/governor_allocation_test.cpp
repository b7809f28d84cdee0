// A period of the loop asks the heap for nothing.

#include <array>
#include <limits>

#include <gtest/gtest.h>

#include "hardware/safety/governor.h"

#include "tests/hardware/allocation_count.h"
#include "tests/hardware/safety/governor_rig.h"

namespace handgraft::safety {
namespace {

using namespace test;
using handgraft::test::allocationCount;

TEST(GovernorAllocation, NoPeriodAllocatesInAnyState) {
  GovernorOptions options = quickOptions();
  Governor governor(options);
  const std::vector<std::string> other_order{"index", "thumb"}, wrong{"index", "palm"};
  const std::vector<double> near{0.05, 0.05}, far{1.2, -0.5};
  const std::vector<double> rubbish{std::numeric_limits<double>::quiet_NaN(), 0}, few{1.0};
  std::vector<double> position{0.0, 0.0};
  Time now{1h};
  std::uint64_t number = 0;
  bool powered = false;
  std::array<int, 6> visits{};

  const long before = allocationCount();
  for (int k = 0; k < 20000; ++k) {
    now += k % 997 == 0 ? 200ms : 10ms;
    const int phase = k % 1000;
    if (phase < 400) {
      const auto& names = k % 3 == 0 ? other_order : k % 7 == 0 ? wrong : options.names;
      const auto& pose = k % 11 == 0 ? rubbish : k % 13 == 0 ? few : phase < 200 ? near : far;
      governor.offer({1 + static_cast<std::uint64_t>(phase > 380), ++number, 0, names, pose},
                     now);
      governor.renew(1, now);
    }
    if (phase % 100 == 0) governor.arm(now);
    if (phase == 350) governor.disarm();
    if (phase == 250 && k % 2000 < 1000) governor.estop();
    if (phase % 150 == 149) governor.reset();
    const DeviceReport report{phase < 950,  powered, phase == 600 ? 4u : 0u,
                              phase == 120, now,     position};
    const MotorOrder order = governor.tick(report, now);
    powered = order.power == Power::kOn;
    for (std::size_t i = 0; i < order.positions.size(); ++i)
      position[i] = order.positions[i];
    ++visits[static_cast<std::size_t>(governor.state())];
  }
  const long allocated = allocationCount() - before;

  EXPECT_EQ(allocated, 0);
  for (std::size_t i = 0; i < visits.size(); ++i)
    EXPECT_GT(visits[i], 0) << toString(static_cast<GovernorState>(i));
}

TEST(GovernorAllocation, TheCountCounts) {
  const long before = allocationCount();
  const std::vector<double> some(100);
  EXPECT_EQ(allocationCount() - before, 1) << some.size();
}

}  // namespace
}  // namespace handgraft::safety
