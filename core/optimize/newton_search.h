#pragma once

#include <vector>

#include <Eigen/Core>

#include "core/optimize/envelope_cholesky.h"
#include "core/optimize/objective.h"
#include "core/optimize/search_space.h"

namespace handgraft::optimize {

/// Knobs of the bounded Newton method; the defaults are measured (DECISIONS).
struct NewtonSettings {
  double first_damping = 1.0;  ///< share of the Gauss-Newton diagonal
  double longest_turn = 1.0;   ///< rad, of the root or a joint in one step
  double promise = 1e-9;       ///< share of the objective; a step that promises less ends it
  bool exact = true;           ///< also try the exact Hessian
};

/// Bounded Levenberg-Marquardt with an active set, from one pose downhill.
///
/// Each step minimises a damped quadratic model of Eq. 2 in the box: with the exact Hessian
/// where that is positive definite over the coordinates that move, else with the Gauss-Newton
/// matrix. Coordinates that would leave the box are put on its border and the rest follows,
/// until none is left. A step is accepted by the ratio of gain to promise, and damped as
/// Nielsen has it. The root moves on SE(3): R <- exp(w) R.
///
/// Cost: about 6 us a step for 26 degrees of freedom, whatever the number of pairs; nothing is
/// allocated after construction.
/// Source: Kanzow, Yamashita & Fukushima 2004 (Levenberg-Marquardt under constraints); Nielsen
/// 1999, "Damping parameter in Marquardt's method".
class NewtonSearch {
 public:
  /// Keeps references to all three; `objective` may be used by others between `begin`s.
  NewtonSearch(const PoseProblem& problem, const SearchSpace& space, Objective& objective);

  NewtonSettings settings;

  /// Sets out from `pose`, inside its bounds; with the `damping` of a search to go on with, or
  /// 0. Costs an evaluation of the objective, which counts as the one that made the pose.
  void begin(const hand::HandPose& pose, double damping = 0.0);

  enum class Step {
    kBetter,         ///< `pose` is a better one
    kConverged,      ///< no step promises a gain worth having
    kStuck,          ///< none that promises one keeps it
    kNoEvaluations,  ///< they ran out before a better pose was found
  };

  /// One better pose, after as many trials as that takes; counts `evaluations` down.
  Step improve(int& evaluations);

  [[nodiscard]] const hand::HandPose& pose() const { return pose_; }

  [[nodiscard]] const Terms& terms() const { return terms_; }

  [[nodiscard]] double damping() const { return damping_; }

 private:
  void expand();
  /// The step and what it promises to gain.
  double propose();
  [[nodiscard]] bool proposeBy(bool exact);
  [[nodiscard]] bool solveMoving(bool exact);
  [[nodiscard]] bool holdLeavers();
  [[nodiscard]] double promiseOf(bool exact, double share) const;
  void moveTo(hand::HandPose& pose) const;

  /// Entry of the Hessian by two entries of the space.
  [[nodiscard]] double hessian(int i, int j, bool exact) const {
    const auto& H = exact ? exact_ : gauss_newton_;
    return i >= j ? H(j, i) : H(i, j);
  }

  const SearchSpace& space_;
  Objective& objective_;
  hand::HandPose pose_;
  hand::HandPose trial_;
  Terms terms_;
  QuadraticModel model_;
  EnvelopeCholesky factor_;
  double damping_ = 0.0;
  double growth_ = 2.0;
  bool expanded_ = false;

  // === Of the step at hand, per entry of the space
  int size_ = 0;
  Eigen::VectorXd gradient_;
  Eigen::MatrixXd gauss_newton_;  ///< upper triangle: a column is a row of the lower one
  Eigen::MatrixXd exact_;
  Eigen::VectorXd scale_;  ///< what the damping is a share of
  Eigen::VectorXd lower_gap_;
  Eigen::VectorXd upper_gap_;
  Eigen::VectorXd step_;
  std::vector<char> held_;
  std::vector<int> moving_;  ///< entries not held
  std::vector<int> first_;   ///< their envelope
  std::vector<int> rank_;    ///< how many entries before this one move
  Eigen::VectorXd solution_;
};

}  // namespace handgraft::optimize
