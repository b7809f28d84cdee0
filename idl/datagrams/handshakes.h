#pragma once

#include "idl/datagrams/rtps.h"

/// Whether what a secured domain says in the clear is well formed. Every length in a token must
/// fit: Fast DDS 2.9.1 allocates what a sender says (CVE-2025-62599 and those after it).
namespace handgraft::idl::rtps {

/// The tokens of a participant's announcement, and a lease that ends.
bool hasSoundTokens(const Piece& list);

/// A ParticipantGenericMessage (DDS Security 1.1, 7.4.3.1).
bool isHandshake(const Piece& message);

/// A whole sample that writes: nobody leaves, or is made to leave, in the clear.
bool isPlainSample(const Piece& body, std::uint8_t flags);

}  // namespace handgraft::idl::rtps
