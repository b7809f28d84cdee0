#pragma once

#include <functional>

#include "core/base/progress.h"
#include "core/optimize/pose_problem.h"
#include "core/optimize/solver.h"
#include "idl/sessions.h"
#include "server/admission/rejection.h"
#include "server/admission/workshop.h"

namespace handgraft::server {

/// An edit came while a solve ran, and nothing of that was taken. If the edit is applied, its
/// own solution follows; if it is refused, the solve is to be begun again.
class CutShort : public Rejection {
 public:
  CutShort(std::uint64_t session_id, std::uint64_t solved_revision);

  /// That it was to answer.
  [[nodiscard]] std::uint64_t revision() const { return revision_; }

 private:
  std::uint64_t revision_;
};

/// A final pose that is out, and what its explanation is made of.
struct UnexplainedPose {
  v1::PoseSolution message;  ///< as it was published
  optimize::PoseProblem problem;
  optimize::SolveReport report;
  std::uint64_t asked_at_stops = 0;  ///< as of the session, for what it answers
  // What the stages took.
  double transfer_ms = 0.0;
  double optimize_ms = 0.0;
  double report_ms = 0.0;
};

/// Transfers what is not up to date and solves, the session's own way unless the request says
/// another; better poses on the way are published, at most 1000 a second, and the final one is,
/// then once more when it is explained, and is returned. An edit, a stop or the client's wish
/// after the pose is out end the explanation alone; the pose is returned as it is, and
/// explained later if that edit is refused. Of the session's strand. Errors: CutShort;
/// Rejection (ERROR_CANCELLED) if somebody stopped it; Cancelled on wish.
v1::PoseSolution optimizePose(LiveSession& live,
                              const v1::OptimizeRequest& request,
                              Workshop& workshop,
                              const Progress& progress);

/// Runs a solve of the session's motion, as one that edits may cut short and anybody may stop.
/// Errors: those of `step`; CutShort; Rejection (ERROR_CANCELLED) if somebody stopped it.
void flyMotion(LiveSession& live,
               const Progress& progress,
               const std::function<void(const Progress& told)>& step);

/// The solution that answers edits: what stands, after undo and the like; else the session's
/// way of solving, where the number of starts was left to us from where the hand is, with two,
/// and with roots and directions where they are, so that it follows a drag. Explained by an
/// idle task of the strand: what other sessions have to do comes first. Errors: as above.
void optimizeAfterEdit(LiveSession& live, Workshop& workshop, const Progress& progress);

}  // namespace handgraft::server
