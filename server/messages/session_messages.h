#pragma once

#include "core/session/session.h"
#include "idl/sessions.h"

/// Sessions as they stand, to messages.
namespace handgraft::server {

/// All that a user may change; `state` is filled in by the caller, and times are the motion's
/// own.
v1::SessionSettings settingsMessage(const session::Session& session);

v1::Weights weightsMessage(const optimize::Weights& weights);

/// A place that is held, and how far a pose has it off.
v1::PinnedPoint heldMessage(const session::PinnedPoint& place,
                            const hand::HandModel& model,
                            const hand::HandPose& pose);

v1::CompareReply toMessage(const std::vector<session::Difference>& differences);

}  // namespace handgraft::server
