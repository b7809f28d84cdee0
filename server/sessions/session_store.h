#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "server/sessions/live_session.h"

namespace handgraft::server {

/// The open sessions, by id. Threads: all methods from any thread.
class SessionStore {
 public:
  /// `most` sessions may be open.
  explicit SessionStore(std::uint64_t server_id = 0, std::size_t most = 256)
      : server_id_(server_id), most_(most) {}

  /// Of the server that holds them.
  [[nodiscard]] std::uint64_t serverId() const { return server_id_; }

  /// An id that no session had, of this server or of another one: one that asks for a session
  /// of a server before never comes upon a stranger's. Errors: Rejection (ERROR_OVERLOADED)
  /// when too many are open.
  std::uint64_t reserve();
  void add(std::shared_ptr<LiveSession> session);

  /// Errors: Rejection (ERROR_NOT_FOUND).
  [[nodiscard]] std::shared_ptr<LiveSession> find(std::uint64_t id) const;
  void remove(std::uint64_t id);

  [[nodiscard]] std::vector<std::shared_ptr<LiveSession>> all() const;
  [[nodiscard]] std::size_t size() const;

 private:
  const std::uint64_t server_id_;
  const std::size_t most_;
  mutable std::mutex mutex_;
  std::map<std::uint64_t, std::shared_ptr<LiveSession>> sessions_;
};

}  // namespace handgraft::server
