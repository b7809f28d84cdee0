#pragma once

#include <string>

namespace handgraft {

/// Where the programs meet on DDS: the same two options on every one of them.
struct Network {
  int domain = 0;                ///< 0-100: higher ones run into ephemeral ports
  std::string interface = "lo";  ///< name of a network interface of this machine
};

inline constexpr int kHighestDomain = 100;

/// An IPv4 interface of this machine.
struct NetworkInterface {
  std::string name;
  std::string address;  ///< its first IPv4 address, dotted
  bool loopback = false;
};

/// Looks the interface up and checks the domain.
///
/// Errors: InvalidInput for a domain outside 0-100, or an interface that does not exist or has
/// no IPv4 address (the message lists those there are). Cost: a few system calls.
NetworkInterface validate(const Network& network);

/// "domain 7, interface lo", for messages.
std::string describe(const Network& network);

}  // namespace handgraft
