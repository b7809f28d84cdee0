#pragma once

#include <filesystem>
#include <string>

namespace handgraft::test {

/// The project's own source folder, for models and test files that it ships.
std::filesystem::path sourceDirectory();

/// Real hands, objects and contact maps that the project may test with but not ship:
/// `../shared/data` beside the clone, or HANDGRAFT_SHARED_DATA.
std::filesystem::path sharedData(const std::string& relative);

/// A fresh folder of this test process, removed at its end.
std::filesystem::path scratchDirectory();

}  // namespace handgraft::test

/// Skips the test, with the reason, on machines that have only the clone.
#define HANDGRAFT_NEEDS_SHARED_DATA(relative)                                            \
  do {                                                                                   \
    if (!std::filesystem::exists(::handgraft::test::sharedData(relative)))               \
      GTEST_SKIP() << "needs ../shared/data/" << (relative) << ", which is not part of " \
                   << "the project";                                                     \
  } while (false)
