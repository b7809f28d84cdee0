#pragma once

#include "core/optimize/solver.h"

namespace handgraft::session {

inline constexpr int kMostStarts = 10'000;
inline constexpr int kMostEvaluations = 100'000;  ///< a start

/// How a session searches its pose; idl's SolveOptions with the defaults filled in.
struct SolverSettings {
  optimize::Solver solver = optimize::kDefaultSolver;
  int starts = optimize::kDefaultStarts;
  unsigned seed = 0;
  int max_evaluations = optimize::kDefaultEvaluations;  ///< a start
  /// The paper's own way: one start, the prior, which follows the last result; MMA; patches
  /// stay where they were laid, open directions and roots, too. `solver` and `starts` keep
  /// their defaults and play no part.
  bool paper = false;
  optimize::NormalForm normal_form = optimize::NormalForm::kCosine;
  /// The hand's depth in the object, and in itself, is charged while solving; never in the
  /// paper's way.
  bool avoid_penetration = true;

  /// Whether it is, after all.
  [[nodiscard]] bool avoids() const { return avoid_penetration && !paper; }

  friend bool operator==(const SolverSettings&, const SolverSettings&) = default;
};

/// Of what follows an edit: where the hand is, and its joints under the closed form.
inline constexpr int kStartsAfterEdit = 2;

/// What answers an edit of a pose that is known: so few starts, unless somebody said how many.
SolverSettings afterEdit(SolverSettings solving);

/// Errors: InvalidInput naming the number that is out of range, or the solver or starts that
/// `paper` leaves no room for.
void validate(const SolverSettings& solving);

/// What the solver is told of it; the form of the normals and the charge for depth belong to
/// the problem. Errors: as `validate`.
optimize::SolveOptions solveOptions(const SolverSettings& solving);

}  // namespace handgraft::session
