#pragma once

#include <optional>

#include "core/session/edit.h"
#include "idl/edits.h"
#include "server/sessions/live_session.h"

namespace handgraft::server {

/// An edit at a time, with what it needs of the motion's answer: where a place or a joint is.
/// Errors: InvalidInput if the session holds no motion, the time is none of it, or such an edit
/// has no time.
session::TimedEdit timedEdit(LiveSession& live,
                             const v1::EditTime& when,
                             const session::Edit& edit);

/// An edit of all of a session as it is applied. In one that holds a motion a joint is locked
/// at the middle of what it does there. Errors: InvalidInput for an edit that a motion does not
/// know: its object goes its own way, and recorded points have no outline on the hand that
/// could be moved.
session::Edit wholeEdit(LiveSession& live, session::Edit edit);

/// The time at which an edit of all of a motion is made, reaching over all of it: of roots and
/// directions on the hand, which are where the motion lays them, time by time, and are moved
/// from there. Nothing for all other edits, and in a session of a grasp.
std::optional<v1::EditTime> timeOfWholeEdit(LiveSession& live, const session::Edit& edit);

}  // namespace handgraft::server
