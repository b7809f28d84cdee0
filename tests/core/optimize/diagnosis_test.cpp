// What a diagnosis says, against closed forms and against solving again by another solver.

#include "core/optimize/diagnosis.h"

#include <algorithm>
#include <cmath>
#include <fstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/io/problem_file.h"
#include "core/optimize/solver.h"

#include "tests/support/shared_data.h"

namespace handgraft::optimize {
namespace {

constexpr double kArm = 0.1;     // m
constexpr double kLimit = 0.5;   // rad
constexpr double kWeight = 1e4;  // 1/m^2

/// One joint about z, its root locked; its end shall meet a point at an angle and a radius,
/// normals looking along z and against it.
PoseProblem armAgainst(double angle, double radius, double turned = 0.0) {
  hand::Joint joint;
  joint.name = "elbow";
  joint.type = hand::JointType::kRevolute;
  joint.parent_link = "root";
  joint.child_link = "arm";
  joint.axis_J = Eigen::Vector3d::UnitZ();
  joint.lower = -kLimit;
  joint.upper = kLimit;
  PoseProblem problem = makeProblem(std::make_shared<const hand::HandModel>(
      "arm", std::vector<hand::Link>{{"root", {}, {}}, {"arm", {}, {}}},
      std::vector<hand::Joint>{joint}));
  problem.locked.assign(7, true);
  problem.locked[6] = false;
  problem.weights = {kWeight, 1.0, 0.0};
  PointPair pair;
  pair.link = 1;
  pair.p_L = {kArm, 0.0, 0.0};
  pair.n_L = Eigen::Vector3d::UnitZ();
  pair.p_W = {radius * std::cos(angle), radius * std::sin(angle), 0.0};
  pair.n_W = {std::sin(turned), 0.0, -std::cos(turned)};
  pair.patch = 3;
  problem.pairs = {pair};
  return problem;
}

Diagnosis diagnosed(const PoseProblem& problem) {
  return diagnose(problem, solve(problem, {}, Progress()));
}

/// Of the distance term, with the joint at `q` and the target at `angle` on the arm's circle.
double objectiveAt(double q, double angle) {
  return kWeight * kArm * kArm * 2.0 * (1.0 - std::cos(angle - q));
}

TEST(Diagnosis, KnowsSlopeAndGainOfALimitInClosedForm) {
  for (const double side : {1.0, -1.0}) {
    const double angle = 0.9;
    const Diagnosis diagnosis = diagnosed(armAgainst(side * angle, kArm));
    ASSERT_EQ(diagnosis.sensitivities.size(), 1U);
    const LimitSensitivity& sensitivity = diagnosis.sensitivities[0];
    EXPECT_EQ(sensitivity.upper, side > 0.0);
    EXPECT_NEAR(sensitivity.limit, side * kLimit, 1e-12);
    EXPECT_NEAR(sensitivity.slope, kWeight * kArm * kArm * 2.0 * std::sin(angle - kLimit),
                1e-6);
    EXPECT_NEAR(sensitivity.given, 0.1, 1e-9);
    EXPECT_NEAR(sensitivity.gain, objectiveAt(kLimit, angle) - objectiveAt(kLimit + 0.1, angle),
                1e-6);
    // The chord to the target shrinks from 2 L sin(a/2).
    const double chord = 2.0 * kArm * std::sin(0.5 * (angle - kLimit));
    const double after = 2.0 * kArm * std::sin(0.5 * (angle - kLimit - 0.1));
    EXPECT_NEAR(sensitivity.gain_mm, 1e3 * (chord - after), 1e-6);
  }
}

TEST(Diagnosis, GivesNoMoreThanIsOfUse) {
  const double angle = kLimit + 0.04;
  const Diagnosis diagnosis = diagnosed(armAgainst(angle, kArm));
  ASSERT_EQ(diagnosis.sensitivities.size(), 1U);
  EXPECT_NEAR(diagnosis.sensitivities[0].given, 0.04, 1e-4);
  EXPECT_NEAR(diagnosis.sensitivities[0].gain, objectiveAt(kLimit, angle), 1e-6);
}

TEST(Diagnosis, NamesNoLimitThatDoesNotHold) {
  EXPECT_TRUE(diagnosed(armAgainst(0.2, kArm)).sensitivities.empty());
}

TEST(Diagnosis, TellsAPatchAtALimit) {
  const Diagnosis diagnosis = diagnosed(armAgainst(kLimit + 0.3, kArm));
  ASSERT_EQ(diagnosis.patches.size(), 1U);
  const PatchDiagnosis& patch = diagnosis.patches[0];
  EXPECT_EQ(patch.patch, 3);
  EXPECT_EQ(patch.verdict, Verdict::kAtLimit);
  EXPECT_NEAR(patch.miss_mm, 2e3 * kArm * std::sin(0.15) - DiagnosisOptions().reached_mm, 1e-3);
  ASSERT_EQ(patch.sensitivities.size(), 1U);
  EXPECT_GT(patch.sensitivities[0].gain_mm, 5.0);
}

TEST(Diagnosis, TellsAPatchOutOfReach) {
  const Diagnosis diagnosis = diagnosed(armAgainst(0.2, kArm + 0.02));
  ASSERT_EQ(diagnosis.patches.size(), 1U);
  EXPECT_EQ(diagnosis.patches[0].verdict, Verdict::kOutOfReach);
  EXPECT_NEAR(diagnosis.patches[0].alone_mm, 20.0, 1e-3);
  EXPECT_TRUE(diagnosis.patches[0].sensitivities.empty());
}

TEST(Diagnosis, TellsReachedAndFacingAway) {
  EXPECT_EQ(diagnosed(armAgainst(0.2, kArm)).patches.at(0).verdict, Verdict::kReached);
  const Diagnosis turned = diagnosed(armAgainst(0.2, kArm, 1.2));
  EXPECT_EQ(turned.patches.at(0).verdict, Verdict::kFacingWrong);
  EXPECT_NEAR(turned.patches.at(0).facing_deg, 1.2 * 180.0 / 3.14159265358979, 1e-6);
}

TEST(Diagnosis, CountsThePatchesThatAreMissed) {
  const auto missed_of = [](const PoseProblem& problem) {
    return missedPatches(problem, solve(problem, {}, Progress())).size();
  };
  EXPECT_EQ(missed_of(armAgainst(0.2, kArm)), 0U);
  EXPECT_EQ(missed_of(armAgainst(0.2, kArm, 1.2)), 1) << "it faces away";
  // Of two on one arm, 0.3 rad apart, the heavier one is met.
  PoseProblem both = armAgainst(0.2, kArm);
  both.pairs.push_back(armAgainst(0.5, kArm).pairs[0]);
  both.pairs[1].patch = 4;
  EXPECT_EQ(missed_of(both), 2) << "in the middle";
  both.pairs[0].weight = 1e3;
  EXPECT_EQ(missed_of(both), 1);
  both.pairs[1].weight = 0.0;
  EXPECT_EQ(missed_of(both), 0) << "without a weight nobody asks for it";
}

TEST(Diagnosis, CallsABentPatchOnARoundFingerReached) {
  PoseProblem problem = armAgainst(0.2, kArm);
  const PointPair middle = problem.pairs[0];
  for (const double bend : {-1.1, 1.1}) {
    PointPair rim = middle;
    rim.n_L = {0.0, std::sin(bend), std::cos(bend)};
    problem.pairs.push_back(rim);
  }
  const SolveReport report = solve(problem, {}, Progress());
  EXPECT_GT(report.patches.at(0).normal_mean_deg, 40.0);
  EXPECT_EQ(diagnose(problem, report).patches.at(0).verdict, Verdict::kReached);
}

TEST(Diagnosis, SaysNothingOfAPatchThatIsSwitchedOff) {
  PoseProblem problem = armAgainst(0.2, kArm + 0.02);
  problem.pairs[0].weight = 0.0;
  EXPECT_EQ(diagnosed(problem).patches.at(0).verdict, Verdict::kNone);
}

TEST(Diagnosis, OfContradictingBoundsIsEmpty) {
  PoseProblem problem = armAgainst(0.2, kArm);
  problem.lower[0] = 1.0;
  EXPECT_TRUE(diagnosed(problem).patches.empty());
}

/// One prediction and what solving again says.
struct Checked {
  double predicted;
  double solved;
};

/// The gain of moving one limit of a problem, solved again from the answer by SLSQP.
double gainBySolving(const PoseProblem& problem,
                     const SolveReport& report,
                     const ActiveLimit& limit) {
  SolveOptions options;
  options.solver = Solver::kSlsqp;
  options.starts = 1;
  PoseProblem again = problem;
  again.start = report.pose;
  const double before = solve(again, options, Progress()).terms.objective;
  const double step = DiagnosisOptions().step_rad;
  if (limit.upper) {
    again.upper[limit.dof] += step;
  } else {
    again.lower[limit.dof] -= step;
  }
  return before - solve(again, options, Progress()).terms.objective;
}

TEST(Diagnosis, IsTrueToSolvingAgainOnRealProblems) {
  HANDGRAFT_NEEDS_SHARED_DATA("problems");
  std::ifstream stream(test::sharedData("problems/reference.json"));
  const auto reference = nlohmann::json::parse(stream);
  std::vector<Checked> checked;
  int unnamed = 0;
  int compared = 0;
  int swapped = 0;
  for (const auto& [name, entry] : reference.items()) {
    const PoseProblem problem = io::readProblem(test::sharedData("problems/" + name + ".json"));
    const SolveReport report = solve(problem, {}, Progress());
    const Diagnosis diagnosis = diagnose(problem, report);
    std::vector<Checked> here;
    for (const ActiveLimit& limit : report.active_limits) {
      const double solved = gainBySolving(problem, report, limit);
      const auto sensitivity =
          std::find_if(diagnosis.sensitivities.begin(), diagnosis.sensitivities.end(),
                       [&](const LimitSensitivity& one) {
                         return one.dof == limit.dof && one.upper == limit.upper;
                       });
      if (sensitivity != diagnosis.sensitivities.end()) {
        here.push_back({sensitivity->gain, solved});
      } else if (diagnosis.sensitivities.size() < 8) {
        ++unnamed;
        EXPECT_LT(solved, 1e-3 * report.terms.objective) << name << ' ' << limit.dof;
      }
    }
    for (std::size_t i = 0; i < here.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        if (std::abs(here[i].solved - here[j].solved) < 1e-3 * report.terms.objective) continue;
        ++compared;
        if ((here[i].predicted > here[j].predicted) != (here[i].solved > here[j].solved))
          ++swapped;
      }
    }
    checked.insert(checked.end(), here.begin(), here.end());
  }
  ASSERT_GT(checked.size(), 80U);
  const auto within = [&](double factor) {
    return std::count_if(checked.begin(), checked.end(), [factor](const Checked& one) {
      return one.predicted > one.solved / factor && one.predicted < one.solved * factor;
    });
  };
  const auto count = static_cast<double>(checked.size());
  EXPECT_GE(static_cast<double>(within(1.1)), 0.90 * count);
  EXPECT_GE(static_cast<double>(within(2.0)), 0.97 * count);
  EXPECT_LE(swapped, compared / 50);
  std::printf(
      "%zu sensitivities: %td within 10 %%, %td within a factor of 2; %d unnamed; %d of %d "
      "ranked otherwise\n",
      checked.size(), within(1.1), within(2.0), unnamed, swapped, compared);
}

}  // namespace
}  // namespace handgraft::optimize
