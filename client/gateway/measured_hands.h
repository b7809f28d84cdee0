#pragma once

#include <functional>
#include <map>
#include <memory>

#include "client/link/client.h"
#include "idl/cyclone/participant.h"
#include "idl/hardware.h"

namespace handgraft::client::gateway {

/// The joints that bridges measure, on the network of a client: the newest of each.
///
/// Threads: one.
class MeasuredHands {
 public:
  /// The client outlives it.
  explicit MeasuredHands(Client& client) : client_(client) {}

  /// What has come since the last call, of each bridge that follows a session. Errors:
  /// TransportError.
  void take(const std::function<void(const v1::JointState&)>& use);

  /// Listens no more, until the next `take`.
  void rest();

 private:
  Client& client_;
  std::shared_ptr<const idl::cyclone::Participant> participant_;  ///< that is listened on
  std::unique_ptr<idl::cyclone::Reader<v1::JointState>> reader_;
};

}  // namespace handgraft::client::gateway
