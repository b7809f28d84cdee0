#include "core/optimize/nlopt_solver.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <memory>

#include <nlopt.h>

#include "core/base/error.h"

namespace handgraft::optimize {

namespace {

nlopt_algorithm algorithmOf(Solver solver) {
  switch (solver) {
    case Solver::kMma:
      return NLOPT_LD_MMA;
    case Solver::kCcsaq:
      return NLOPT_LD_CCSAQ;
    case Solver::kSlsqp:
      return NLOPT_LD_SLSQP;
    case Solver::kLbfgs:
      return NLOPT_LD_LBFGS;
    case Solver::kTnewton:
      return NLOPT_LD_TNEWTON_PRECOND_RESTART;
    case Solver::kVar2:
      return NLOPT_LD_VAR2;
    case Solver::kLm:
    case Solver::kAll:
      break;
  }
  HANDGRAFT_REQUIRE(false && "one of NLopt's");
  return NLOPT_LD_MMA;
}

/// What travels through NLopt's void pointer.
struct Run {
  const BoxProblem& problem;
  nlopt_opt handle;
  Eigen::VectorXd x;
  Eigen::VectorXd gradient;
  int evaluations = 0;
  bool asked_to_stop = false;
  std::exception_ptr error;

  [[nodiscard]] bool over() const {
    return asked_to_stop || error != nullptr || evaluations >= problem.max_evaluations;
  }
};

// Plain C calls this: no exception may leave it.
double sample(unsigned count, const double* x, double* gradient, void* data) noexcept {
  Run& run = *static_cast<Run*>(data);
  if (gradient != nullptr) std::fill(gradient, gradient + count, 0.0);
  if (run.over()) {
    nlopt_force_stop(run.handle);
    return HUGE_VAL;
  }
  try {
    run.x = Eigen::Map<const Eigen::VectorXd>(x, count);
    // A failed line search may propose NaN; the box clamps everything else.
    if (!run.x.allFinite()) return HUGE_VAL;
    run.x = run.x.cwiseMax(run.problem.lower).cwiseMin(run.problem.upper);
    ++run.evaluations;
    const Sample result = run.problem.function(run.x, run.gradient);
    run.asked_to_stop = result.stop;
    if (run.over()) nlopt_force_stop(run.handle);
    if (!std::isfinite(result.value) || !run.gradient.allFinite()) return HUGE_VAL;
    if (gradient != nullptr) Eigen::Map<Eigen::VectorXd>(gradient, count) = run.gradient;
    return result.value;
  } catch (...) {
    run.error = std::current_exception();
    nlopt_force_stop(run.handle);
    return HUGE_VAL;
  }
}

Stop stopOf(nlopt_result result, const Run& run) {
  if (run.asked_to_stop) return Stop::kAsked;
  if (run.evaluations >= run.problem.max_evaluations) return Stop::kEvaluations;
  switch (result) {
    case NLOPT_SUCCESS:
    case NLOPT_FTOL_REACHED:
    case NLOPT_XTOL_REACHED:
    case NLOPT_STOPVAL_REACHED:
      return Stop::kTolerance;
    case NLOPT_MAXEVAL_REACHED:
      return Stop::kEvaluations;
    case NLOPT_OUT_OF_MEMORY:
      throw std::bad_alloc();
    default:
      // NLOPT_FAILURE is how L-BFGS, VAR2 and TNEWTON say that a step at a bound led nowhere.
      return Stop::kRoundoff;
  }
}

}  // namespace

Stop minimizeInBox(Solver solver, const BoxProblem& problem) {
  const Eigen::Index count = problem.start.size();
  HANDGRAFT_REQUIRE(count > 0);
  HANDGRAFT_REQUIRE(problem.lower.size() == count && problem.upper.size() == count);
  HANDGRAFT_REQUIRE((problem.lower.array() <= problem.start.array()).all());
  HANDGRAFT_REQUIRE((problem.start.array() <= problem.upper.array()).all());
  if (problem.max_evaluations <= 0) return Stop::kEvaluations;

  const std::unique_ptr<nlopt_opt_s, decltype(&nlopt_destroy)> handle(
      nlopt_create(algorithmOf(solver), static_cast<unsigned>(count)), &nlopt_destroy);
  if (handle == nullptr) throw std::bad_alloc();
  Run run{problem, handle.get(), problem.start, Eigen::VectorXd::Zero(count),
          0,       false,        nullptr};
  const bool accepted = nlopt_set_min_objective(handle.get(), sample, &run) > 0 &&
                        nlopt_set_lower_bounds(handle.get(), problem.lower.data()) > 0 &&
                        nlopt_set_upper_bounds(handle.get(), problem.upper.data()) > 0 &&
                        nlopt_set_ftol_rel(handle.get(), problem.relative_tolerance) > 0 &&
                        nlopt_set_maxeval(handle.get(), problem.max_evaluations) > 0;
  HANDGRAFT_REQUIRE(accepted);

  Eigen::VectorXd x = problem.start;
  double value = 0.0;
  const nlopt_result result = nlopt_optimize(handle.get(), x.data(), &value);
  if (run.error != nullptr) std::rethrow_exception(run.error);
  return stopOf(result, run);
}

}  // namespace handgraft::optimize
