#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace handgraft::test {

/// A test with a folder of its own, which does not exist yet and is gone afterwards.
class OwnFolder : public ::testing::Test {
 protected:
  OwnFolder() {
    const ::testing::TestInfo& test = *::testing::UnitTest::GetInstance()->current_test_info();
    folder = std::filesystem::path(::testing::TempDir()) /
             (std::string(test.test_suite_name()) + "_" + test.name());
    std::filesystem::remove_all(folder);
  }

  ~OwnFolder() override { std::filesystem::remove_all(folder); }

  [[nodiscard]] std::vector<std::filesystem::path> files() const {
    std::vector<std::filesystem::path> found;
    if (!std::filesystem::exists(folder)) return found;
    for (const auto& entry : std::filesystem::directory_iterator(folder))
      found.push_back(entry.path());
    return found;
  }

  std::filesystem::path folder;
};

}  // namespace handgraft::test
