#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/base/network.h"

namespace handgraft::idl {

/// What a name service says of a name.
struct NameAnswer {
  std::string address;    ///< dotted; empty: none
  std::string why;        ///< there is none
  bool is_final = false;  ///< false: asked again, it may know
};

using NameService = std::function<NameAnswer(const std::string& name)>;

/// As getaddrinfo has it.
NameAnswer askNameService(const std::string& name);

/// The network with addresses in place of its peers' names.
///
/// Each name is asked for again every quarter of a second while nobody answers, for 2 s: name
/// services of containers lose a question while they learn of a container that came or went,
/// and the C library alone would wait 5 s for its answer, of each server in turn.
///
/// Errors: InvalidInput for a peer without an address, TransportError where the name service
/// does not answer; `without_address` takes such peers instead. Questions that are never
/// answered are left behind with their threads.
Network withPeerAddresses(const Network& network,
                          std::vector<std::string>* without_address = nullptr,
                          const NameService& service = askNameService);

}  // namespace handgraft::idl
