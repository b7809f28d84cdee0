#pragma once

#include <functional>

#include "core/base/network.h"

namespace handgraft::server {

/// Asks the server that runs as process `process_id` of this machine twice a second, as clients
/// do, and calls `on_status` for each of its statuses, with true where it counts a request
/// more: it heard one, did it, and says so. No reader of answers, which would be sent those of
/// all clients, too.
///
/// Until `is_over`. Errors: InvalidInput for a network or an identity that does not let it ask;
/// TransportError.
void probeServer(const Network& network,
                 unsigned process_id,
                 const std::function<void(bool)>& on_status,
                 const std::function<bool()>& is_over);

}  // namespace handgraft::server
