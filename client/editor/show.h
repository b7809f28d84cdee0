#pragma once

#include <string>

#include "client/editor/told.h"
#include "idl/sessions.h"

/// What the editor says about what a session is made of: the topics of `show`.
namespace handgraft::client::editor {

/// "you", "client 7845ab12" (as the server names it), or "nobody".
std::string nameOf(const v1::ClientId& client, const v1::ClientId& own);

/// `own`: of this program.
Told tellSession(const v1::SessionSettings& settings, const v1::ClientId& own);
Told tellPatches(const v1::SessionSettings& settings);
Told tellJoints(const v1::SessionSettings& settings);
Told tellSettings(const v1::SessionSettings& settings);
Told tellHistory(const v1::SessionSettings& settings);
Told tellSnapshots(const v1::SessionSettings& settings);
/// What was edited at times of a motion.
Told tellTimes(const v1::SessionSettings& settings);

Told tellDifferences(const v1::CompareReply& reply);

}  // namespace handgraft::client::editor
