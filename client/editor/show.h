#pragma once

#include <string>

#include "client/editor/command_output.h"
#include "idl/models.h"
#include "idl/sessions.h"

/// What the editor says about what a session is made of: the topics of `show`.
namespace handgraft::client::editor {

/// "you", "client 7845ab12" (as the server names it), or "nobody".
std::string nameOf(const v1::ClientId& client, const v1::ClientId& own);

/// `own`: of this program.
CommandOutput tellSession(const v1::SessionSettings& settings, const v1::ClientId& own);
CommandOutput tellPatches(const v1::SessionSettings& settings);
CommandOutput tellJoints(const v1::SessionSettings& settings);
CommandOutput tellSettings(const v1::SessionSettings& settings);
CommandOutput tellHistory(const v1::SessionSettings& settings);
CommandOutput tellSnapshots(const v1::SessionSettings& settings);
/// What was edited at times of a motion.
CommandOutput tellTimes(const v1::SessionSettings& settings);

/// Of the snapshots `a` and `b`; an empty `b` is the session as it is now. `hand` says which of
/// its joints slide.
CommandOutput tellDifferences(const v1::CompareReply& reply,
                              const std::string& a,
                              const std::string& b,
                              const v1::HandDescription& hand);

}  // namespace handgraft::client::editor
