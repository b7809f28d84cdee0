#pragma once

#include <functional>

#include <Eigen/Core>

#include "core/optimize/solver.h"

namespace handgraft::optimize {

/// Why a run of NLopt ended.
enum class Stop {
  kTolerance,    ///< a relative tolerance was met
  kRoundoff,     ///< rounding kept it from going on, or its line search failed
  kEvaluations,  ///< `max_evaluations` were used up
  kAsked         ///< the function asked for it
};

/// The value at a point and whether to go on; the gradient comes by the second argument.
struct Sample {
  double value = 0.0;
  bool stop = false;
};

using BoxFunction = std::function<Sample(const Eigen::VectorXd& x, Eigen::VectorXd& gradient)>;

/// A function to minimise in a box; infinite bounds are allowed.
struct BoxProblem {
  BoxFunction function;
  Eigen::VectorXd lower;
  Eigen::VectorXd upper;
  Eigen::VectorXd start;
  int max_evaluations = 1000;
  /// Of the value, between two steps of the solver.
  double relative_tolerance = 1e-8;
};

/// Runs one of NLopt's gradient solvers. It returns no point: `function` sees all of them and
/// keeps the best, which need not be the last.
///
/// Errors: what `function` throws is kept, the run stopped, and the same exception thrown from
///   here (NLopt would replace it by its own). `function` is not called again after it threw,
///   asked to stop, or used up its evaluations, whatever the solver still tries.
Stop minimizeInBox(Solver solver, const BoxProblem& problem);

}  // namespace handgraft::optimize
