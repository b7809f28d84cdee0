#pragma once

#include "core/base/network.h"

namespace handgraft::idl::cyclone {

/// Who is not heard for so long is dropped by the others.
inline constexpr int kLeaseDuration = 20;  // s

/// Whom a program meets. Discovery, and in a secured domain handshakes, are of each with each.
enum class Discovers {
  kAll,
  kNoClients,       ///< a client, which says nothing to others of its kind
  kStartingServer,  ///< as that; a server that misses some while it starts hears of it soon
};

/// This process' share of a domain, which is configured once however many participants join it;
/// the last one to go takes it along. Threads: any.
class Domain {
 public:
  /// All are met as soon as one of its participants meets all.
  /// Errors: InvalidInput for a network that is none, or other settings than those with which
  /// this process is on that domain already; TransportError.
  Domain(const Network& network, Discovers discovers);
  ~Domain();
  Domain(const Domain&) = delete;
  Domain& operator=(const Domain&) = delete;

 private:
  int id_;
};

}  // namespace handgraft::idl::cyclone
