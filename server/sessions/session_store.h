#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "server/sessions/live_session.h"

namespace handgraft::server {

/// The open sessions, by id, and those that sleep on disk until somebody asks for them.
/// Threads: all methods from any thread.
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
  /// It sleeps no more, if it did.
  void add(std::shared_ptr<LiveSession> session);

  /// Errors: Rejection (ERROR_NOT_FOUND).
  [[nodiscard]] std::shared_ptr<LiveSession> find(std::uint64_t id) const;
  void remove(std::uint64_t id);

  /// Errors: Rejection (ERROR_OVERLOADED) when too many are open.
  void requireRoom() const;

  /// It is not open any more, and sleeps in this state.
  void sleep(v1::SessionState state);
  /// Nothing unless it sleeps.
  [[nodiscard]] std::optional<v1::SessionState> asleep(std::uint64_t id) const;
  /// States of all, open or not.
  [[nodiscard]] std::vector<v1::SessionState> states() const;

  [[nodiscard]] std::vector<std::shared_ptr<LiveSession>> all() const;
  /// How many are open.
  [[nodiscard]] std::size_t size() const;
  /// With those that sleep.
  [[nodiscard]] std::size_t countAll() const;

 private:
  const std::uint64_t server_id_;
  const std::size_t most_;
  mutable std::mutex mutex_;
  std::map<std::uint64_t, std::shared_ptr<LiveSession>> sessions_;
  std::map<std::uint64_t, v1::SessionState> asleep_;
};

}  // namespace handgraft::server
