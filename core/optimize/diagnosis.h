#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/base/progress.h"
#include "core/optimize/solve_report.h"

namespace handgraft::optimize {

/// What a solution says of one patch.
enum class Verdict {
  kNone,         ///< switched off
  kReached,      ///< near enough, facing the right way
  kAtLimit,      ///< joints at their limits keep it away
  kOutOfReach,   ///< so does the rest of the hand
  kFacingWrong,  ///< near enough, facing the wrong way
  kNoClearance,  ///< whatever the pose: the finger is too thick (core/verdict judges that)
};

/// `none reached at_limit out_of_reach normals_in_conflict no_clearance`.
std::string_view nameOf(Verdict verdict);

struct DiagnosisOptions {
  /// Mean distance at which a patch counts as reached, and the most that its mean normals may
  /// be off: measured over real grasps (README).
  double reached_mm = 6.0;
  double facing_deg = 60.0;
  /// How far a limit is moved out.
  double step_rad = 0.1;
  double step_m = 0.002;  ///< of a sliding joint
  /// A limit is worth naming from so much on: share of the objective.
  double least_gain = 1e-4;
};

/// Whether a patch counts as reached: near enough, facing the right way.
constexpr bool isReached(double mean_mm,
                         double facing_deg,
                         const DiagnosisOptions& options = DiagnosisOptions()) {
  return mean_mm <= options.reached_mm && facing_deg <= options.facing_deg;
}

/// What it would bring to move one joint limit out.
struct LimitSensitivity {
  int dof = 0;  ///< of the hand
  bool upper = false;
  double limit = 0.0;    ///< as it stands; rad, m
  double slope = 0.0;    ///< fall of the objective per rad or m given: the multiplier, >= 0
  double given = 0.0;    ///< moved out by: the options', or less where the gain ends before
  double gain = 0.0;     ///< fall of the objective
  double gain_mm = 0.0;  ///< fall of the mean distance: of the patch, or over all points
};

struct PatchDiagnosis {
  int patch = -1;
  Verdict verdict = Verdict::kNone;
  double facing_deg = 0.0;  ///< between the mean normals of both sides; a bend costs nothing
  double miss_mm = 0.0;     ///< mean distance beyond what counts as reached
  double alone_mm = 0.0;    ///< mean distance if this patch alone had to be reached
  /// By which the finger is too thick for the place, as core/verdict finds; 0: not known to be.
  double missing_clearance_m = 0.0;
  /// Those that bring it nearer, largest `gain_mm` first; at most three.
  std::vector<LimitSensitivity> sensitivities;
};

struct Diagnosis {
  std::vector<PatchDiagnosis> patches;          ///< in the order of the report's
  std::vector<LimitSensitivity> sensitivities;  ///< largest gain first; at most eight
};

/// Says why each patch is where it is.
///
/// A limit's slope is its multiplier at the pose. Its gain is that of a short search from the
/// pose with that limit alone moved out by a step. Multiplier and curvature alone promise
/// too much or too little (other limits come into the way, or lose their hold). A patch that is
/// not reached is at its limits if a search with all active limits moved out by five steps
/// takes away half of its miss; else it is out of reach. The pose stays what it is.
///
/// Errors: BrokenContract unless the report is the problem's and has been judged. Cancelled on
/// wish, within one of those searches.
/// Cost: 20 us a limit that pushes, 50 us a patch that is not reached.
Diagnosis diagnose(const PoseProblem& problem,
                   const SolveReport& report,
                   const DiagnosisOptions& options = {},
                   const Progress& progress = Progress());

/// The patches that count (with a weight) and lack kReached at the report's pose, as their
/// points name them. Errors: as diagnose. Cost: O(points).
std::vector<int> missedPatches(const PoseProblem& problem,
                               const SolveReport& report,
                               const DiagnosisOptions& options = {});

/// Per patch of `report.patches`, the angle between the mean normals of hand and object, the
/// latter turned round, degrees.
std::vector<double> facingAngles(const PoseProblem& problem, const SolveReport& report);

}  // namespace handgraft::optimize
