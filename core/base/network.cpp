#include "core/base/network.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <memory>
#include <optional>
#include <system_error>
#include <vector>

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netdb.h>
#include <netinet/in.h>

#include "core/base/error.h"

namespace handgraft {

namespace {

std::string dotted(const sockaddr_in& address) {
  std::array<char, INET_ADDRSTRLEN> text{};
  inet_ntop(AF_INET, &address.sin_addr, text.data(), text.size());
  return text.data();
}

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
    found.push_back({name, dotted(*reinterpret_cast<const sockaddr_in*>(at->ifa_addr)),
                     (at->ifa_flags & IFF_LOOPBACK) != 0U});
  }
  return found;
}

/// What may be part of a topic's name in ROS 2.
bool isServerName(const std::string& name) {
  const auto is_letter = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
  };
  return name.size() <= kLongestServerName && is_letter(name.front()) &&
         std::all_of(name.begin(), name.end(), [&](char c) {
           return is_letter(c) || (c >= '0' && c <= '9') || c == '_';
         });
}

/// Nothing if the name service knows none.
std::optional<std::string> addressOf(const std::string& peer, std::string& why) {
  addrinfo wanted{};
  wanted.ai_family = AF_INET;
  wanted.ai_socktype = SOCK_DGRAM;
  addrinfo* first = nullptr;
  const int error = getaddrinfo(peer.c_str(), nullptr, &wanted, &first);
  if (error != 0 || peer.empty()) {
    why = gai_strerror(error);
    return std::nullopt;
  }
  const std::unique_ptr<addrinfo, void (*)(addrinfo*)> list(first, freeaddrinfo);
  return dotted(*reinterpret_cast<const sockaddr_in*>(first->ai_addr));
}

}  // namespace

NetworkInterface validate(const Network& network) {
  if (network.domain < 0 || network.domain > kHighestDomain) {
    rejectInput("domain: {} is outside 0-{}", network.domain, kHighestDomain);
  }
  if (network.peers.size() > kMostPeers)
    rejectInput("peers: {} are given; at most {} may be", network.peers.size(), kMostPeers);
  if (!network.server.empty() && !isServerName(network.server)) {
    rejectInput(
        "server: {} is no name of one: a letter, then letters, digits and underscores, at most "
        "{} in all",
        quoted(network.server), kLongestServerName);
  }
  const std::vector<NetworkInterface> there = interfacesOfThisMachine();
  for (const NetworkInterface& one : there) {
    const bool is_meant = network.interface == "auto" ? !one.loopback
                                                      : network.interface == one.name ||
                                                            network.interface == one.address;
    if (is_meant) return one;
  }
  std::string names;
  for (const NetworkInterface& one : there) {
    names += (names.empty() ? "" : ", ") + one.name;
  }
  rejectInput(
      "interface: {} is not an interface with an IPv4 address, nor the address of one; "
      "there are: {}",
      quoted(network.interface), names.empty() ? "none" : names);
}

std::vector<std::string> unicastAddresses(const Network& network,
                                          const NetworkInterface& interface,
                                          std::vector<std::string>* without_address) {
  std::vector<std::string> addresses;
  if (interface.loopback || !network.peers.empty()) addresses.push_back(interface.address);
  for (const std::string& peer : network.peers) {
    std::string why;
    const std::optional<std::string> address = addressOf(peer, why);
    if (!address && without_address != nullptr) {
      without_address->push_back(peer);
    } else if (!address) {
      rejectInput("peers: {} has no IPv4 address: {}", quoted(peer), why);
    } else if (std::find(addresses.begin(), addresses.end(), *address) == addresses.end()) {
      addresses.push_back(*address);
    }
  }
  return addresses;
}

std::string describe(const Network& network) {
  std::string text = fmt::format("domain {}, interface {}", network.domain, network.interface);
  if (!network.server.empty()) text += ", server " + network.server;
  if (!network.identity.empty()) text += ", identity " + network.identity;
  for (std::size_t i = 0; i < network.peers.size(); ++i)
    text += (i == 0 ? ", peers " : " ") + network.peers[i];
  return text;
}

}  // namespace handgraft
