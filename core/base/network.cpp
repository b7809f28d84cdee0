#include "core/base/network.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <memory>
#include <system_error>
#include <vector>

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>

#include "core/base/error.h"

namespace handgraft {

namespace {

std::vector<NetworkInterface> interfacesOfThisMachine() {
  ifaddrs* first = nullptr;
  if (getifaddrs(&first) != 0) {
    throw TransportError(fmt::format("the network interfaces cannot be listed: {}",
                                     std::generic_category().message(errno)));
  }
  const std::unique_ptr<ifaddrs, void (*)(ifaddrs*)> list(first, freeifaddrs);
  std::vector<NetworkInterface> found;
  for (const ifaddrs* at = list.get(); at != nullptr; at = at->ifa_next) {
    if (at->ifa_addr == nullptr || at->ifa_addr->sa_family != AF_INET) continue;
    if ((at->ifa_flags & IFF_UP) == 0U) continue;
    const std::string name = at->ifa_name;
    const bool known =
        std::any_of(found.begin(), found.end(), [&](const NetworkInterface& one) {
          return one.name == name;
        });
    if (known) continue;
    std::array<char, INET_ADDRSTRLEN> text{};
    const auto* address = reinterpret_cast<const sockaddr_in*>(at->ifa_addr);
    if (inet_ntop(AF_INET, &address->sin_addr, text.data(), text.size()) == nullptr) continue;
    found.push_back({name, text.data(), (at->ifa_flags & IFF_LOOPBACK) != 0U});
  }
  return found;
}

}  // namespace

NetworkInterface validate(const Network& network) {
  if (network.domain < 0 || network.domain > kHighestDomain) {
    rejectInput("domain: {} is outside 0-{}", network.domain, kHighestDomain);
  }
  const std::vector<NetworkInterface> there = interfacesOfThisMachine();
  for (const NetworkInterface& one : there) {
    if (one.name == network.interface) return one;
  }
  std::string names;
  for (const NetworkInterface& one : there) {
    names += (names.empty() ? "" : ", ") + one.name;
  }
  rejectInput("interface: {} is not an interface with an IPv4 address; there are: {}",
              quoted(network.interface), names.empty() ? "none" : names);
}

std::string describe(const Network& network) {
  return fmt::format("domain {}, interface {}", network.domain, network.interface);
}

}  // namespace handgraft
