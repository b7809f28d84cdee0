#pragma once

#include <cstdint>
#include <utility>

#include "client/link/client.h"

namespace handgraft::client {

/// A session that is closed however its command ends, unless it is to be kept.
class KeptSession {
 public:
  KeptSession(Client& server, v1::SessionState state)
      : server_(server), state_(std::move(state)) {}

  ~KeptSession() {
    if (kept_) return;
    try {
      server_.closeSession(state_.session_id()).get();
    } catch (const std::exception&) {
      // The reason why the command ends is the one to report; a server that is gone has closed
      // it.
    }
  }

  KeptSession(const KeptSession&) = delete;
  KeptSession& operator=(const KeptSession&) = delete;

  [[nodiscard]] const v1::SessionState& state() const { return state_; }

  [[nodiscard]] std::uint64_t id() const { return state_.session_id(); }

  /// `tells` people so; a server of this command's own ends with it, whatever is kept.
  void keep(bool tells);

 private:
  Client& server_;
  v1::SessionState state_;
  bool kept_ = false;
};

}  // namespace handgraft::client
