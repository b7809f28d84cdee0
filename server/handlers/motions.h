#pragma once

#include <string>

#include "core/base/progress.h"
#include "idl/motions.h"
#include "server/admission/workshop.h"

namespace handgraft::server {

/// Has the session's hand follow its motion, and keeps the answer. Edits wait for its end;
/// anybody may stop it. Of the session's strand.
/// Errors: InvalidInput if the session holds no motion, and as session::solveMotion.
v1::MotionSummary solveMotion(LiveSession& live,
                              const v1::SolveMotionRequest& request,
                              Workshop& workshop,
                              const Progress& progress);

/// Frames of the last answer, as many as are asked for and fit into a message. Of the session's
/// strand. Errors: InvalidInput if there is none, or it has no such frame.
v1::MotionFrames motionFrames(LiveSession& live, const v1::MotionFramesRequest& request);

/// Of a session that holds a motion: its last answer as a file.
/// Errors: InvalidInput if there is none, or motions have no such format.
std::string motionExport(LiveSession& live, v1::ExportFormat format);

}  // namespace handgraft::server
