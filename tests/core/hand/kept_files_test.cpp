#include "core/hand/kept_files.h"

#include <array>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>

#include <gtest/gtest.h>

#include "tests/support/own_folder.h"

namespace handgraft::hand {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFormat = "test/1\n";

const std::string& keyOfAll() {
  static const std::string key(64, 'k');
  return key;
}

TEST(SealedBytes, GiveTheirContentBack) {
  for (const std::string& content : {std::string(), std::string("some\0thing", 10)})
    EXPECT_EQ(unsealed(sealed(kFormat, keyOfAll(), content), kFormat, keyOfAll()), content);
}

TEST(SealedBytes, AreNothingIfDamagedOrOfOtherThings) {
  const std::string bytes = sealed(kFormat, keyOfAll(), "content");
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    std::string damaged = bytes;
    damaged[i] = static_cast<char>(damaged[i] ^ 1);
    EXPECT_FALSE(unsealed(damaged, kFormat, keyOfAll())) << "byte " << i;
    EXPECT_FALSE(unsealed(bytes.substr(0, i), kFormat, keyOfAll())) << "cut at " << i;
  }
  EXPECT_FALSE(unsealed(bytes + "x", kFormat, keyOfAll()));
  EXPECT_FALSE(unsealed(bytes, "test/2\n", keyOfAll()));
  EXPECT_FALSE(unsealed(bytes, kFormat, std::string(64, 'b')));
}

TEST(KeptNumbers, AreTakenOnlyIfThereAreSoMany) {
  std::string bytes;
  const std::array<double, 2> numbers{1.5, -2.0};
  appendNumbers(bytes, numbers.data(), numbers.size());
  std::string_view rest = bytes;
  std::array<double, 3> back{};
  EXPECT_FALSE(takeNumbers(rest, back.data(), 3));
  EXPECT_EQ(rest.size(), bytes.size()) << "what was refused is still there";
  ASSERT_TRUE(takeNumbers(rest, back.data(), 2));
  EXPECT_EQ(back[0], 1.5);
  EXPECT_EQ(back[1], -2.0);
  EXPECT_TRUE(rest.empty());
}

class KeptFilesTest : public test::OwnFolder {
 protected:
  static std::optional<std::string> findIn(const KeptFiles& files) {
    return files.find("name", [](std::string_view bytes) {
      return bytes == "bad" ? std::nullopt : std::optional<std::string>(bytes);
    });
  }
};

TEST_F(KeptFilesTest, AreFoundAgain) {
  const KeptFiles files(folder / "own");
  EXPECT_EQ(findIn(files), std::nullopt);
  files.keep("name", "content");
  EXPECT_EQ(findIn(files), "content");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder / "own"), fs::directory_iterator()), 1);
}

TEST_F(KeptFilesTest, ThatCameWithTheProgramAreReadFirstAndNeverWritten) {
  KeptFiles(folder / "shipped").keep("name", "shipped");
  const KeptFiles files(folder / "own", folder / "shipped");
  files.keep("name", "own");
  EXPECT_EQ(findIn(files), "shipped");
  KeptFiles(folder / "shipped").keep("name", "bad");
  EXPECT_EQ(findIn(files), "own") << "one of no use hides none";
}

TEST_F(KeptFilesTest, AreNoneWithoutAFolder) {
  const KeptFiles files(std::nullopt);
  files.keep("name", "content");
  EXPECT_EQ(findIn(files), std::nullopt);
  std::ofstream(folder) << "a file where the folder should be";
  const KeptFiles elsewhere(folder);
  elsewhere.keep("name", "content");
  EXPECT_EQ(findIn(elsewhere), std::nullopt);
}

}  // namespace
}  // namespace handgraft::hand
