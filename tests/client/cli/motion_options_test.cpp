// What the `motion` commands take, and how they say what is wrong with it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/cli/command_line.h"
#include "core/base/error.h"

namespace handgraft::client {
namespace {

using testing::AllOf;
using testing::HasSubstr;

template <class Options>
Options parsedAs(const std::vector<std::string>& words) {
  std::vector<const char*> argv = {"handgraft", "motion"};
  for (const std::string& word : words)
    argv.push_back(word.c_str());
  const auto parsed = parseCommandLine(static_cast<int>(argv.size()), argv.data());
  return std::get<Options>(std::get<Invocation>(parsed).command);
}

std::string motionObjection(const std::vector<std::string>& words) {
  try {
    (void)parsedAs<MotionSolveOptions>(words);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

TEST(MotionOptions, SolveTakesHowAndWhatToWrite) {
  const auto solve = parsedAs<MotionSolveOptions>(
      {"solve", "--hand", "human20", "--motion", "pull", "--causal", "--fade", "90", "--out",
       "a.npz", "--out", "b.xml", "--acceleration", "40"});
  EXPECT_TRUE(solve.causal);
  EXPECT_NEAR(solve.fade_s, 0.09, 1e-12);
  EXPECT_EQ(solve.smoothness, 0.0);
  EXPECT_EQ(solve.acceleration_limit, 40.0);
  ASSERT_EQ(solve.out.size(), 2u);
  EXPECT_EQ(solve.out[0].format, "npz");
  EXPECT_EQ(solve.out[1].format, "mjcf");
  EXPECT_EQ(solve.object, "");
}

TEST(MotionOptions, JoinIsCalledAfterItsFirstGrasp) {
  const auto join = parsedAs<MotionImportOptions>(
      {"join", "box_5", "last.json", "--path", "keys.csv", "--slide", "0.1", "0.9"});
  EXPECT_EQ(join.name, "box_5");
  EXPECT_FALSE(join.is_named);
  EXPECT_EQ(join.slide_begin, 0.1);
  EXPECT_EQ(join.slide_end, 0.9);
  EXPECT_FALSE(join.vanish.has_value());
}

TEST(MotionOptions, ExportKnowsItsFormatByTheEnding) {
  EXPECT_EQ(parsedAs<ExportOptions>({"export", "3", "--out", "a.html"}).format, "html");
  EXPECT_EQ(parsedAs<ExportOptions>({"export", "3", "--out", "a.yaml"}).format,
            "ros_trajectory");
  EXPECT_TRUE(parsedAs<ExportOptions>({"export", "3", "--out", "a.json"}).is_of_motion);
}

TEST(MotionOptions, SayWhatIsWrong) {
  const std::vector<std::string> solve = {"solve", "--hand", "human20", "--motion", "pull"};
  const auto with = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words = solve;
    words.insert(words.end(), more.begin(), more.end());
    return motionObjection(words);
  };
  EXPECT_THAT(with({"--out", "a.bvh"}), AllOf(HasSubstr("a.bvh"), HasSubstr(".npz")));
  EXPECT_THAT(with({"--fade", "-1"}), AllOf(HasSubstr("--fade"), HasSubstr("above 0")));
  EXPECT_THAT(with({"--smoothness", "nan"}), HasSubstr("--smoothness"));
  EXPECT_THAT(with({"--starts", "20000"}), HasSubstr("at most 10000"));
  EXPECT_THAT(with({"--units", "mm"}), HasSubstr("--units"));
  EXPECT_THAT(motionObjection({"join", "a", "b", "--path", "p.csv", "--vanish", "1.5"}),
              AllOf(HasSubstr("--vanish"), HasSubstr("0 to 1")));
  EXPECT_THAT(motionObjection({"join", "a", "b", "--path", "p.csv", "--rate", "0"}),
              HasSubstr("--rate"));
  EXPECT_THAT(motionObjection({}), HasSubstr("solve"));
}

}  // namespace
}  // namespace handgraft::client
