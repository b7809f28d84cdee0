// The solver's commands run and print what the README says. No figure of time is judged.
#include <algorithm>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/process.h"
#include "tests/support/shared_data.h"

namespace handgraft::bench {
namespace {

int linesOf(const std::string& text) {
  return static_cast<int>(std::count(text.begin(), text.end(), '\n'));
}

TEST(SolverBench, SolveRanksMinimaByAnySolver) {
  HANDGRAFT_NEEDS_SHARED_DATA("problems");
  const std::string problem = test::sharedData("problems/dexycb_mug_g0_fav.json").string();
  for (const std::string solver : {"lm", "all"}) {
    const test::Finished bench =
        test::run(HANDGRAFT_BENCH, {"solve", problem, "--solver", solver, "--starts", "4"});
    ASSERT_EQ(bench.exit_code, 0) << bench.err;
    const auto line = nlohmann::json::parse(bench.out);
    EXPECT_EQ(line["theta"].size(), 26U);
    ASSERT_GE(line["minima"].size(), 1U);
    EXPECT_NEAR(line["minima"][0]["objective"].get<double>(), line["objective"].get<double>(),
                1e-9);
    EXPECT_EQ(line["minima"][0]["solver"], line["solver"]);
  }
}

TEST(SolverBench, PaperModeIsMmaFromOneStart) {
  HANDGRAFT_NEEDS_SHARED_DATA("problems");
  const std::string problem = test::sharedData("problems/dexycb_mug_g0_fav.json").string();
  const test::Finished bench = test::run(HANDGRAFT_BENCH, {"solve", problem, "--paper"});
  ASSERT_EQ(bench.exit_code, 0) << bench.err;
  const auto line = nlohmann::json::parse(bench.out);
  EXPECT_EQ(line["solver"], "mma");
  EXPECT_EQ(line["best_start"], 0);
  EXPECT_LE(line["evaluations"].get<int>(), 1000);
}

TEST(SolverBench, TablesHaveALineForEachProblemCountAndSolver) {
  HANDGRAFT_NEEDS_SHARED_DATA("problems");
  const std::string folder = test::sharedData("problems").string();
  const test::Finished scaling =
      test::run(HANDGRAFT_BENCH, {"scaling", folder, "--repeat", "1"});
  ASSERT_EQ(scaling.exit_code, 0) << scaling.err;
  EXPECT_EQ(linesOf(scaling.out), 8);
  const test::Finished placements =
      test::run(HANDGRAFT_BENCH, {"placements", folder, "--placements", "1"});
  ASSERT_EQ(placements.exit_code, 0) << placements.err;
  EXPECT_EQ(placements.out.rfind("14 poor placements", 0), 0U) << placements.out;
  const test::Finished baseline =
      test::run(HANDGRAFT_BENCH, {"baseline", folder, "--repeat", "1", "--tolerance", "1e-2"});
  ASSERT_EQ(baseline.exit_code, 0) << baseline.err;
  EXPECT_NE(baseline.out.find("| dexycb_mug_g0_fav |"), std::string::npos);
  EXPECT_NE(baseline.out.find("| DART + SLSQP |"), std::string::npos);
}

TEST(SolverBench, RefusesAFolderWithoutReference) {
  for (const std::string command : {"baseline", "scaling", "placements", "solvers"}) {
    const test::Finished bench =
        test::run(HANDGRAFT_BENCH, {command, (test::sourceDirectory() / "docker").string()});
    EXPECT_EQ(bench.exit_code, 2) << command;
    EXPECT_NE(bench.err.find("reference.json"), std::string::npos) << bench.err;
  }
}

// Skins are made for these two: of the hand that takes least.
TEST(SolverBench, PairsAreWrittenAsProblemsAndSolvedFromThere) {
  const std::filesystem::path out = test::scratchDirectory() / "pairs";
  const test::Finished bench =
      test::run(HANDGRAFT_BENCH, {"pairs", out.string(), "--hand", "barrett8", "--models",
                                  HANDGRAFT_MODELS, "--placements", "1", "--repeat", "1",
                                  "--cache", test::scratchDirectory().string()});
  ASSERT_EQ(bench.exit_code, 0) << bench.err;
  EXPECT_EQ(bench.out.rfind("4 pairs", 0) == 0U || bench.out.rfind("8 pairs", 0) == 0U, true)
      << bench.out;
  EXPECT_NE(bench.out.find("| 14 |"), std::string::npos) << bench.out;
  const test::Finished again =
      test::run(HANDGRAFT_BENCH, {"solve", (out / "barrett8_lemon_6_0.json").string()});
  EXPECT_EQ(again.exit_code, 0) << again.err;
}

TEST(SolverBench, PaperTablesHaveFavourableAndPoorStarts) {
  const test::Finished bench = test::run(
      HANDGRAFT_BENCH, {"tables", "--hand", "barrett8", "--models", HANDGRAFT_MODELS,
                        "--repeat", "1", "--cache", test::scratchDirectory().string()});
  ASSERT_EQ(bench.exit_code, 0) << bench.err;
  EXPECT_NE(bench.out.find("| scissors_3 | 3 | favourable | 0.081 s / 0 |"), std::string::npos)
      << bench.out;
  EXPECT_NE(bench.out.find("| lemon_6 | 4 | poor | 0.183 s / 0 |"), std::string::npos)
      << bench.out;
  EXPECT_NE(bench.out.find(" of 6; farthest apart"), std::string::npos) << bench.out;
}

}  // namespace
}  // namespace handgraft::bench
