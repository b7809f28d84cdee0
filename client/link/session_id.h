#pragma once

#include <cstdint>

#include "client/link/client.h"

namespace handgraft::client {

/// The session that people mean by a number: its id, or the first digits of it, at least four,
/// where only one session of the server begins so. Any other number is returned as it is, for
/// the server to refuse.
/// Errors: InvalidInput if several sessions begin so, naming them; those of the client.
std::uint64_t sessionMeant(Client& server, std::uint64_t typed);

}  // namespace handgraft::client
