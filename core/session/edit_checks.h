#pragma once

#include <string>

#include "core/base/pose.h"
#include "core/optimize/pose_problem.h"
#include "core/optimize/problem_options.h"

// What numbers an edit, or a file of a session, may bring.
namespace handgraft::session {

inline constexpr double kLargestJointValue = 1e3;  // rad or m
inline constexpr double kLargestTurn = 1e3;        // rad
inline constexpr double kLargestLambda = 1e12;
inline constexpr double kLargestPosition = 1e3;  // m
inline constexpr double kBoundTolerance = 1e-9;  // solver and optimiser agree on it

/// Errors of all: InvalidInput naming the thing, its value and the range.
void requireRigid(const Pose& X, const char* what);
/// `unit` is told behind the numbers; empty: they have none.
void requireWithin(double value,
                   double least,
                   double most,
                   const std::string& what,
                   const std::string& unit = {});
void validateWeights(const optimize::Weights& weights);
void validateShares(const optimize::PriorShares& shares);

}  // namespace handgraft::session
