#include "core/optimize/pose_problem.h"

#include <cmath>
#include <functional>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"

#include "tests/core/optimize/problems.h"

namespace handgraft::optimize {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

PoseProblem sound() {
  std::mt19937 random(1);
  return test::randomProblem(test::syntheticHand(), 5, random);
}

TEST(PoseProblem, BeginsAtRestWithTheModelsLimits) {
  const PoseProblem problem = makeProblem(test::syntheticHand());
  EXPECT_NO_THROW(validate(problem));
  EXPECT_EQ(problem.dofCount(), 10);
  EXPECT_EQ(problem.lower, problem.model->lower());
  EXPECT_EQ(problem.start.q, problem.model->restPose());
  EXPECT_EQ(dofName(problem, 0), "root_rx");
  EXPECT_EQ(dofName(problem, 5), "root_tz");
  EXPECT_EQ(dofName(problem, 6), "a1");
}

struct Fault {
  const char* what;
  const char* message;  ///< part of it
  std::function<void(PoseProblem&)> damage;
};

class Damaged : public testing::TestWithParam<Fault> {};

TEST_P(Damaged, IsRefusedByName) {
  PoseProblem problem = sound();
  ASSERT_NO_THROW(validate(problem));
  GetParam().damage(problem);
  try {
    validate(problem);
    FAIL() << "accepted";
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr(GetParam().message));
    EXPECT_THAT(error.what(), testing::Not(testing::HasSubstr("\n")));
  }
}

INSTANTIATE_TEST_SUITE_P(PoseProblem,
                         Damaged,
                         testing::Values(Fault{"NoHand", "no hand",
                                               [](auto& p) {
                                                 p.model = nullptr;
                                               }},
                                         Fault{"NanWeight", "weight of the distance",
                                               [](auto& p) {
                                                 p.weights.distance = kNan;
                                               }},
                                         Fault{"NegativeWeight", "weight of the prior",
                                               [](auto& p) {
                                                 p.weights.prior = -1;
                                               }},
                                         Fault{"ShortStart", "start: has 1 entries",
                                               [](auto& p) {
                                                 p.start.q.resize(1);
                                               }},
                                         Fault{"NanStart", "start",
                                               [](auto& p) {
                                                 p.start.q[1] = kNan;
                                               }},
                                         Fault{"NanPrior", "prior",
                                               [](auto& p) {
                                                 p.prior.X_WH.translation()[0] = kNan;
                                               }},
                                         Fault{"ScaledRotation", "not a rotation",
                                               [](auto& p) {
                                                 p.start.X_WH.linear() *= 1.1;
                                               }},
                                         Fault{"MirroredRotation", "not a rotation",
                                               [](auto& p) {
                                                 p.start.X_WH.linear().col(0) *= -1.0;
                                               }},
                                         Fault{"ShortBounds", "lower bounds",
                                               [](auto& p) {
                                                 p.lower.resize(2);
                                               }},
                                         Fault{"NanBound", "'a1'",
                                               [](auto& p) {
                                                 p.upper[0] = kNan;
                                               }},
                                         Fault{"StartOutside", "'a1': the start 0 lies outside",
                                               [](auto& p) {
                                                 p.lower[0] = 0.1;
                                               }},
                                         Fault{"RootOutside", "root_ty",
                                               [](auto& p) {
                                                 p.root_lower[1] = 1.0;
                                               }},
                                         Fault{"NoSuchLink", "pair 2: link 7",
                                               [](auto& p) {
                                                 p.pairs[2].link = 7;
                                               }},
                                         Fault{"NegativeLink", "pair 2: link -1",
                                               [](auto& p) {
                                                 p.pairs[2].link = -1;
                                               }},
                                         Fault{"LongNormal", "pair 1: the hand normal",
                                               [](auto& p) {
                                                 p.pairs[1].n_L *= 1.01;
                                               }},
                                         Fault{"NanNormal", "pair 1: the object normal",
                                               [](auto& p) {
                                                 p.pairs[1].n_W[0] = kNan;
                                               }},
                                         Fault{"InfinitePoint", "pair 0",
                                               [](auto& p) {
                                                 p.pairs[0].p_W[2] = kInfinity;
                                               }},
                                         Fault{"NegativePairWeight", "pair 3: weight",
                                               [](auto& p) {
                                                 p.pairs[3].weight = -0.1;
                                               }},
                                         Fault{"ShortLocks", "locked",
                                               [](auto& p) {
                                                 p.locked.assign(4, false);
                                               }},
                                         Fault{"ShortPriorWeights", "prior weights",
                                               [](auto& p) {
                                                 p.prior_weights.resize(3);
                                               }},
                                         Fault{"NanPriorWeight", "prior weight of 'root_rz'",
                                               [](auto& p) {
                                                 p.prior_weights[2] = kNan;
                                               }}),
                         [](const auto& test) {
                           return test.param.what;
                         });

TEST(PoseProblem, ForgivesWhatRoundingInFilesCosts) {
  PoseProblem problem = sound();
  problem.lower[0] = problem.start.q[0] + 5e-10;
  EXPECT_NO_THROW(validate(problem));
}

TEST(PoseProblem, NormalsThatCountForNothingMayBeAny) {
  PoseProblem problem = sound();
  ASSERT_FALSE(problem.pairs.empty());
  problem.pairs[0].n_L.setZero();
  EXPECT_THROW(validate(problem), InvalidInput);
  problem.pairs[0].has_normals = false;
  EXPECT_NO_THROW(validate(problem));
}

TEST(PoseProblem, ContradictingBoundsAreFoundAndNotRefused) {
  PoseProblem problem = sound();
  EXPECT_FALSE(boundsContradict(problem));
  problem.root_lower[2] = 1.0;
  problem.root_upper[2] = -1.0;
  EXPECT_TRUE(boundsContradict(problem));
  EXPECT_NO_THROW(validate(problem));
}

}  // namespace
}  // namespace handgraft::optimize
