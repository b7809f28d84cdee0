#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace handgraft::server {

/// Of a datagram that tells nothing but where its sender stands (RTPS 2.x).
struct SenderState {
  /// Who tells whom: the same for a later one, which makes this one needless. Empty of all
  /// other datagrams, which have to be heard each.
  std::string key;
  /// HEARTBEATs alone: what its writers have. They come again while they are not answered.
  bool is_heartbeat = false;
};

/// Of HEARTBEATs and ACKNACKs, and nothing else. Cost: O(submessages).
SenderState senderStateOf(std::span<const std::uint8_t> datagram);

}  // namespace handgraft::server
