// The way from joints to motors and back asks the heap for nothing.

#include <gtest/gtest.h>

#include "hardware/tendon/synergy_map.h"
#include "hardware/tendon/tendon_map.h"

#include "tests/hardware/allocation_count.h"
#include "tests/hardware/tendon/hands.h"

namespace handgraft::tendon {
namespace {

using handgraft::test::allocationCount;

void expectNone(MotorMap& map, double q0) {
  const std::vector<double> q(map.jointCount(), q0);
  std::vector<double> motors(map.motorCount()), residual(q.size()), measured(q.size());
  const long before = allocationCount();
  for (int i = 0; i < 100; ++i) {
    map.command(q, motors, residual);
    map.measure(motors, measured);
  }
  const long allocated = allocationCount() - before;
  EXPECT_EQ(allocated, 0);
}

TEST(MapAllocation, NoMapAllocates) {
  TendonMap finger(test::workedFinger()), coupled(test::coupledHand()),
      rigid(test::antagonists());
  SynergyMap mimic = mimicMap({{0, 1}, {0, 1}, {0, 1}}, {{2, 1, 0.5, 0}});
  for (MotorMap* map : std::initializer_list<MotorMap*>{&finger, &coupled, &rigid, &mimic})
    expectNone(*map, 0.4);
}

}  // namespace
}  // namespace handgraft::tendon
