#pragma once

#include <filesystem>
#include <memory>

#include "core/optimize/pose_problem.h"

namespace handgraft::bench {

enum class BaselineSolver { kMma, kSlsqp };

struct BaselineRun {
  hand::HandPose pose;
  int steps = 0;        ///< values with gradient, at most 1,000
  int evaluations = 0;  ///< of the objective, those for the gradients included
  double ms = 0.0;      ///< processor time of one solve from the problem's start
};

/// The paper's stack, as its section III-D describes it: DART's kinematics, NLopt, gradients by
/// forward differences, at most 1,000 evaluations from one start.
///
/// Kind to it: link poses are asked for once an evaluation, shapes are left out, DART's own
/// logarithm serves the prior; SLSQP, which gives up on large values, sees a hundredth.
class DartBaseline {
 public:
  /// Keeps a reference to the problem. Errors: std::runtime_error if DART cannot read the URDF.
  DartBaseline(const optimize::PoseProblem& problem, const std::filesystem::path& urdf);
  ~DartBaseline();

  /// Stops at a relative change of `tolerance`.
  BaselineRun solve(BaselineSolver solver, double tolerance);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace handgraft::bench
