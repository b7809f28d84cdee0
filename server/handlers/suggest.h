#pragma once

#include "core/base/progress.h"
#include "idl/sessions.h"
#include "server/sessions/live_session.h"

namespace handgraft::server {

/// Better placements of a patch near its present one, best first; nothing moves, and no
/// revision is counted. Patches that are not up to date are laid out first. Of the session's
/// strand.
///
/// Errors: InvalidInput for an unknown or dropped patch, a reach or a count out of range; the
/// session's phase stays as it was.
v1::SuggestReply suggestPlacements(LiveSession& live,
                                   const v1::SuggestRequest& request,
                                   const Progress& progress);

}  // namespace handgraft::server
