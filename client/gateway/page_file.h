#pragma once

#include <cstdint>
#include <string>

#include "client/gateway/web_files.h"
#include "client/link/client.h"

namespace handgraft::client::gateway {

/// The page and all that it shows of a session, as one HTML file: it needs neither a server nor
/// a network.
///
/// Errors: InvalidInput for a session that has no pose yet, or files that are no page; those of
/// the client.
std::string pageFile(Client& client, std::uint64_t session_id, const WebFiles& files);

}  // namespace handgraft::client::gateway
