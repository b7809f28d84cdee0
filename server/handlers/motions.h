#pragma once

#include <string>

#include "core/base/progress.h"
#include "idl/motions.h"
#include "server/handlers/handler_context.h"

namespace handgraft::server {

/// Errors: InvalidInput if the session holds no motion; where it has no answer yet.
LiveMotion& motionOf(LiveSession& live);
const retargeting::SolvedMotion& solvedOf(LiveSession& live);

/// Has the session's hand follow its motion, and keeps the answer. Edits wait for its end;
/// anybody may stop it. Of the session's strand.
/// Errors: InvalidInput if the session holds no motion, and as retargeting::solveMotion.
v1::MotionSummary solveMotion(LiveSession& live,
                              const v1::SolveMotionRequest& request,
                              HandlerContext& context,
                              const Progress& progress);

/// The session's motion was solved, and is to be solved again after each edit.
bool followsEdits(LiveSession& live);

/// Solves the motion once more as it was asked for last, after edits, which cut it short; what
/// changed is published, the frames about edits at times first. Of the session's strand.
/// Errors: as above.
SolveEnd solveMotionAfterEdit(LiveSession& live,
                              HandlerContext& context,
                              const Progress& progress);

/// As the log of an opened session has it: its motion is to be solved so.
void resumeFollowing(LiveSession& live, const session::FollowedMotion& followed);

/// Frames of the last answer, as many as are asked for and fit into a message. Of the session's
/// strand. Errors: InvalidInput if there is none, or it has no such frame.
v1::MotionFrames motionFrames(LiveSession& live, const v1::MotionFramesRequest& request);

/// Of a session that holds a motion: its last answer as a file.
/// Errors: InvalidInput if there is none, or motions have no such format.
std::string motionExport(LiveSession& live, v1::ExportFormat format);

/// What its hand did after the last demonstrator, likewise. Adds what the file lacks.
/// Errors: InvalidInput if it followed none, or motions have no such format.
std::string liveRunExport(LiveSession& live,
                          v1::ExportFormat format,
                          std::vector<std::string>& notes);

}  // namespace handgraft::server
