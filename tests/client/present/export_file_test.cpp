#include "client/present/export_file.h"

#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace handgraft::client {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

v1::JointSetting joint(const std::string& name, double value, double upper, double own_upper) {
  v1::JointSetting setting;
  setting.name(name);
  setting.kind(v1::JOINT_REVOLUTE);
  setting.value(value);
  setting.lower(0.0);
  setting.upper(upper);
  setting.model_lower(0.0);
  setting.model_upper(own_upper);
  return setting;
}

TEST(BeyondOwnLimits, IsToldOfAPoseThatGoesThere) {
  v1::SessionSettings settings;
  settings.joints() = {joint("within", 1.0, 2.0, 1.5), joint("beyond", 1.6, 2.0, 1.5)};
  EXPECT_THAT(
      beyondOwnLimits(settings),
      ElementsAre(AllOf(HasSubstr("'beyond' is at 91.67 deg"), HasSubstr("85.94 deg"))));
}

TEST(BeyondOwnLimits, IsToldOfAMotionThatMay) {
  v1::SessionSettings settings;
  settings.state().motion("pull");
  settings.joints() = {joint("within", 1.0, 1.5, 1.5), joint("beyond", 1.0, 2.0, 1.5)};
  EXPECT_THAT(beyondOwnLimits(settings), ElementsAre(HasSubstr("'beyond' may go from 0")));
}

TEST(BeyondOwnLimits, DoNotCountNoiseAndWheels) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  v1::SessionSettings settings;
  settings.joints() = {joint("at it", 1.5 + 1e-12, 1.5, 1.5),
                       joint("wheel", 9.0, kNone, kNone)};
  EXPECT_THAT(beyondOwnLimits(settings), IsEmpty());
}

}  // namespace
}  // namespace handgraft::client
