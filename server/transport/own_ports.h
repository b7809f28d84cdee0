#pragma once

#include <optional>
#include <set>

namespace handgraft::server {

/// The UDP ports of a domain's participants (RTPS 2.3, 9.6.1.1) that this process hears on;
/// nothing where the system does not tell.
std::optional<std::set<unsigned>> portsHeard(int domain);

}  // namespace handgraft::server
