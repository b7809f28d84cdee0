#pragma once

#include <string>
#include <vector>

namespace handgraft {

/// Where the programs meet on DDS: the same options on every one of them.
struct Network {
  int domain = 0;  ///< 0-100: higher ones run into ephemeral ports
  /// Name or IPv4 address of a network interface of this machine, or `auto`: the first that is
  /// not the loopback.
  std::string interface = "lo";
  /// Hosts that are told of us one by one, names or IPv4 addresses, for networks that drop
  /// multicast. One end of two need only know the other.
  std::vector<std::string> peers = {};
  /// The name of the server to be, or to meet: one domain may hold several, each of another
  /// name. Empty: the one without a name.
  std::string server = {};
  /// Folder of the identity by which this program takes part in a secured domain
  /// (idl/security). Empty: in an open one.
  std::string identity = {};
};

inline constexpr int kHighestDomain = 100;
/// Programs of a domain on one machine: as many as its 250 ports have room for (RTPS 9.6.1.4,
/// two each from the tenth on).
inline constexpr int kMostProgramsOfAMachine = 120;
inline constexpr std::size_t kLongestServerName = 32;
inline constexpr std::size_t kMostPeers = 32;

/// An IPv4 interface of this machine.
struct NetworkInterface {
  std::string name;
  std::string address;  ///< its first IPv4 address, dotted
  bool loopback = false;
};

/// Looks the interface up and checks the domain and the server's name.
///
/// Errors: InvalidInput for a domain outside 0-100, more than kMostPeers peers, a server's name
/// that is no letter followed by letters, digits and underscores (it becomes part of ROS 2's
/// topics) or is longer than kLongestServerName, or an interface that does not exist or has no
/// IPv4 address (the message lists those there are). Cost: a few system calls.
NetworkInterface validate(const Network& network);

/// The IPv4 addresses, dotted and each once, at which programs are looked for one by one: the
/// peers', and the interface's own on the loopback, where there need be no multicast, and
/// beside peers. Errors: InvalidInput for a peer without an address, unless `without_address`
/// takes such peers. Cost: may ask the name service.
std::vector<std::string> unicastAddresses(const Network& network,
                                          const NetworkInterface& interface,
                                          std::vector<std::string>* without_address = nullptr);

/// "domain 7, interface lo", with the server's name and peers if there are any, for messages.
std::string describe(const Network& network);

}  // namespace handgraft
