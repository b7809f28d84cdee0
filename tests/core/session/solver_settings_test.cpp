#include "core/session/solver_settings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"

namespace handgraft::session {
namespace {

using ::testing::HasSubstr;

std::string refusalOf(const SolverSettings& solving) {
  try {
    validate(solving);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

TEST(SolvingTest, TellsTheSolverWhatWasAskedFor) {
  SolverSettings solving;
  solving.solver = optimize::Solver::kSlsqp;
  solving.starts = 7;
  solving.seed = 3;
  solving.max_evaluations = 55;

  const optimize::SolveOptions options = solveOptions(solving);

  EXPECT_EQ(options.solver, optimize::Solver::kSlsqp);
  EXPECT_EQ(options.starts, 7);
  EXPECT_EQ(options.seed, 3U);
  EXPECT_EQ(options.max_evaluations, 55);
  EXPECT_FALSE(options.from_prior);
}

TEST(SolvingTest, ThePapersWayIsOneStartOfMmaFromThePrior) {
  SolverSettings solving;
  solving.paper = true;
  solving.max_evaluations = 12;

  const optimize::SolveOptions options = solveOptions(solving);

  EXPECT_EQ(options.solver, optimize::Solver::kMma);
  EXPECT_EQ(options.starts, 1);
  EXPECT_TRUE(options.from_prior);
  EXPECT_EQ(options.max_evaluations, 12);
}

TEST(SolvingTest, NamesWhatIsOutOfRange) {
  SolverSettings solving;
  solving.starts = 0;
  EXPECT_THAT(refusalOf(solving), HasSubstr("starts: 0 is outside 1-10000"));
  solving.starts = kMostStarts;
  EXPECT_EQ(refusalOf(solving), "");
  solving.starts = kMostStarts + 1;
  EXPECT_THAT(refusalOf(solving), HasSubstr("starts: 10001"));
  solving = {};
  solving.max_evaluations = 0;
  EXPECT_THAT(refusalOf(solving), HasSubstr("max_evaluations: 0 is outside 1-100000"));
}

TEST(SolvingTest, ThePapersWayLeavesNoChoiceOfSolverAndStarts) {
  SolverSettings solving;
  solving.paper = true;
  solving.solver = optimize::Solver::kSlsqp;
  EXPECT_THAT(refusalOf(solving), HasSubstr("'slsqp'"));
  solving.solver = optimize::kDefaultSolver;
  solving.starts = 5;
  EXPECT_THAT(refusalOf(solving), HasSubstr("starts: 5"));
}

}  // namespace
}  // namespace handgraft::session
