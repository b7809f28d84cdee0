#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "idl/sessions.h"

/// What `transfer` and `suggest` print for people, and what `grasp` says of lost points; as
/// text_output.h.
namespace handgraft::client::text {

/// One row a placed patch, those that were dropped, lost points by reason, notes.
std::string transfer(const v1::TransferReply& reply);

/// The reply's notes but for reasons that its dropped patches tell.
std::vector<std::string> furtherNotes(const v1::TransferReply& reply);

/// The present placement and the suggestions, best first, in one table.
std::string suggestions(const v1::SuggestReply& reply);

/// What became of an applied suggestion: `number` counts from 1.
std::string applied(std::size_t number,
                    const v1::PlacementSuggestion& suggestion,
                    const v1::PatchReport& report,
                    std::uint64_t revision);

/// One line a patch that lost points, by reason, and a last one that names the command that
/// looks for better roots: of `session_id`, or, for 0, of a session that is kept. Empty if none
/// lost any.
std::string losses(const std::vector<v1::PatchReport>& patches, std::uint64_t session_id);

}  // namespace handgraft::client::text
