#pragma once

#include <string>
#include <vector>

#include "core/hand/finger_coordinates.h"
#include "core/session/session.h"
#include "idl/sessions.h"

/// Transfer and suggestions, from messages to core types and back; as convert.h, and checked as
/// there.
namespace handgraft::server {

// === From the wire

/// The defaults when empty. Errors: InvalidInput for a method that does not exist (naming those
/// that do) and for too many rings.
transfer::TransferOptions transferOptionsFrom(const std::vector<v1::TransferOptions>& options);
/// The defaults where a number is 0. Errors: InvalidInput names the number and its range.
transfer::SuggestOptions suggestOptionsFrom(const v1::SuggestRequest& request);

// === To the wire

v1::TransferOptions toMessage(const transfer::TransferOptions& options);
v1::Fidelity toMessage(const transfer::Fidelity& fidelity);
/// `on`: where places of that hand lie.
v1::PatchReport patchReport(const session::SessionPatch& patch,
                            const hand::FingerCoordinates& on);
std::vector<v1::PatchReport> patchReports(const session::Session& session);
/// What there is to say of patches that came through distorted; no note if none did.
std::vector<std::string> distortionNotes(const std::vector<session::SessionPatch>& patches);
/// A note where contacts lie farther apart than any hand reaches, the session's own included:
/// an object in other units than metres. Roots on `object_O`; none for fewer than two.
std::vector<std::string> sizeNotes(const std::vector<session::SessionPatch>& patches,
                                   const geometry::TriangleMesh& object_O,
                                   const geometry::TriangleMesh& skin_S);
v1::PlacementSuggestion toMessage(const transfer::Suggestion& suggestion,
                                  const geometry::TriangleMesh& skin_S);

}  // namespace handgraft::server
