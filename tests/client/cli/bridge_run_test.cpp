// What is kept of a bridge's measurements: rad, and m of what slides.
#include "client/cli/commands/bridge_run.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"

namespace handgraft::client {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

v1::JointState sampleAt(std::int64_t stamp_ns, double finger, double jaw) {
  v1::JointState sample;
  sample.names({"finger", "jaw"});
  sample.sliding({"jaw"});
  sample.position({finger, jaw});
  sample.stamp_ns(stamp_ns);
  return sample;
}

TEST(BridgeRun, NamesTheUnitOfEachJointAndReadsItBack) {
  BridgeRun run;
  ASSERT_TRUE(run.add(sampleAt(1, 0.5, 0.02)));
  const std::string csv = toCsv(run);
  EXPECT_EQ(csv.substr(0, csv.find('\n')),
            "time_s,state,finger measured_rad,finger command_rad,finger target_rad,"
            "finger residual_rad,jaw measured_m,jaw command_m,jaw target_m,jaw residual_m");
  const BridgeRun read = bridgeRunOf(csv);
  EXPECT_EQ(read.joints, run.joints);
  EXPECT_THAT(read.slides, ElementsAre(false, true));
  EXPECT_EQ(read.measured, run.measured);
}

TEST(BridgeRun, RefusesAJointOfTwoUnits) {
  try {
    (void)bridgeRunOf(
        "time_s,state,a measured_rad,a command_m,a target_rad,a residual_rad\n0,idle,,,,\n");
    FAIL() << "it was read";
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(), HasSubstr("column 4"));
  }
}

// By a picture of one joint: of two centimetres of a jaw and a tenth of a radian the jaw's.
TEST(BridgeRun, AJawThatMovesByCentimetresMovesMoreThanAFingerByADegree) {
  const auto drawn = [](const std::string& renamed) {
    BridgeRun run;
    run.add(sampleAt(1, 0.0, 0.0));
    run.add(sampleAt(1'000'000, 0.1, 0.02));
    for (std::string& joint : run.joints)
      if (joint == renamed) joint = "other";
    return drawRun(run, 1).pixels();
  };
  EXPECT_FALSE(drawn("jaw") == drawn(""));
  EXPECT_TRUE(drawn("finger") == drawn(""));
}

}  // namespace
}  // namespace handgraft::client
