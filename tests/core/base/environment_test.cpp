#include "core/base/environment.h"

#include <gtest/gtest.h>

#include "tests/support/environment_variable.h"

namespace handgraft {
namespace {

using test::EnvironmentVariable;

TEST(Environment, IsEmptyWhereAVariableIsNotSet) {
  const EnvironmentVariable none("HANDGRAFT_TEST_VARIABLE", std::nullopt);
  EXPECT_EQ(environment("HANDGRAFT_TEST_VARIABLE"), "");
  const EnvironmentVariable set("HANDGRAFT_TEST_VARIABLE", "a:b");
  EXPECT_EQ(environment("HANDGRAFT_TEST_VARIABLE"), "a:b");
}

TEST(UserFolder, IsWhatTheVariableNamesElseTheUsualOneBelowHome) {
  const EnvironmentVariable home("HOME", "/home/ann");
  const EnvironmentVariable set("XDG_STATE_HOME", "/state/ann");
  EXPECT_EQ(userFolder("XDG_STATE_HOME", ".local/state"), "/state/ann");
  for (const char* unusable : {"", "state", "./state"}) {
    const EnvironmentVariable relative("XDG_STATE_HOME", unusable);
    EXPECT_EQ(userFolder("XDG_STATE_HOME", ".local/state"), "/home/ann/.local/state");
  }
}

TEST(UserFolder, IsNoneWhereNobodySays) {
  const EnvironmentVariable no_state("XDG_STATE_HOME", std::nullopt);
  for (const char* unusable : {"", "home/ann"}) {
    const EnvironmentVariable home("HOME", unusable);
    EXPECT_EQ(userFolder("XDG_STATE_HOME", ".local/state"), std::nullopt);
  }
}

}  // namespace
}  // namespace handgraft
