#pragma once

#include <string>
#include <vector>

#include "core/optimize/diagnosis.h"
#include "core/quality/penetration.h"
#include "core/session/patch_in_the_way.h"
#include "core/verdict/fit_check.h"

namespace handgraft::verdict {

/// What a solution says of itself: the diagnosis of its pose together with what
/// was known of sizes before, and both in words.
struct Verdicts {
  optimize::Diagnosis diagnosis;
  session::PatchInTheWay in_the_way;
  std::vector<std::string> texts;  ///< a line per patch of the diagnosis
  std::string line;                ///< "4 of 5 patches reached; too large for ring (by 1.1 mm)"
  bool too_large = false;
  bool one_sided = false;  ///< two patches and more are reached, and press to one side
};

/// A patch without clearance is not reached whatever the pose says: the pose enters the
/// object. One that is asked for but has no point on the hand counts as not reached, and the
/// line names it. One with less than a quarter of its points on the hand, or its root outside
/// of its boundary, is judged as any other; text and line say so. Of one that alone would be
/// reached the text says what keeps it away: what is held (a drag) where it is that, else the
/// other patches. The line also names the patch in the way of others (patch_in_the_way.h), and
/// tells where two and more are reached and press to one side, so that no forces within their
/// friction cones (of a coefficient of 0.5) hold the object.
///
/// Errors: BrokenContract unless the report is the problem's and the problem the session's.
/// Cancelled on wish.
/// Cost: as optimize::diagnose; where two and more are missed, as session::patchInTheWay: not
/// for what somebody waits for before the pose.
Verdicts verdictsOf(const session::Session& session,
                    const optimize::PoseProblem& problem,
                    const optimize::SolveReport& report,
                    const FitFindings& findings,
                    const Progress& progress = Progress());

/// What is known before a search: "too large for ...", "too small for ..."; empty if nothing
/// is.
std::string lineOf(const session::Session& session, const FitFindings& findings);

/// How deep a pose of the session's hand lies inside the object, its laid patches telling the
/// sides. Cancelled on wish. Cost: below a millisecond once the solids are there.
quality::Penetration penetrationOf(const session::Session& session,
                                   const hand::HandPose& pose,
                                   const Progress& progress);

/// "thumb_mcp upper".
std::string nameOf(const hand::HandModel& model, const optimize::LimitSensitivity& sensitivity);

}  // namespace handgraft::verdict
