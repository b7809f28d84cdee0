#pragma once

#include <chrono>
#include <cstdint>
#include <exception>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "idl/cyclone/participant.h"
#include "idl/cyclone/requester.h"

namespace handgraft::idl::cyclone {

/// The server that is asked, as its statuses tell: who it is, whether it lives, who comes after
/// it, and what servers of other names there are. Threads: one at a time.
class KnownServer {
 public:
  using Clock = std::chrono::steady_clock;
  using Now = std::function<Clock::time_point()>;

  explicit KnownServer(std::string name, Now now = Clock::now)
      : name_(std::move(name)), now_(std::move(now)) {}

  /// A status came. Who says that he is a server, too, waits until the one we know is gone.
  void hear(const v1::ServerStatus& message);

  /// An answer of it came.
  void hearAnswer() { seen_ = now_(); }

  /// This program itself did not get its turn for so long: what it did not hear then is
  /// nobody's silence.
  void forgive(Clock::duration held_up);
  /// Another server is the one to ask once the one before is gone.
  void succeed();

  [[nodiscard]] bool isAlive() const;

  /// Nothing: none was heard yet.
  [[nodiscard]] const std::optional<v1::ServerStatus>& status() const { return status_; }

  /// Rises with each start of a server that is the one to ask; 0: none was heard yet.
  [[nodiscard]] std::uint64_t start() const { return start_; }

  [[nodiscard]] bool isIt(std::uint64_t server_id) const {
    return status_ && status_->server_id() == server_id;
  }

  /// How long nothing came of it, since then at most.
  [[nodiscard]] Clock::duration silenceSince(Clock::time_point begun) const;

  /// Errors: Refused (ERROR_VERSION).
  void requireSameVersion() const;

  /// Why a call of that server, or of any (0), begun then, can hope for nothing; nullptr if it
  /// can.
  [[nodiscard]] std::exception_ptr lossSince(Clock::time_point begun,
                                             std::uint64_t server_id,
                                             const Participant& on) const;
  /// That there is none, and which others there are.
  [[nodiscard]] NoServer none(const Participant& on) const;

 private:
  struct Other {
    std::string host;
    Clock::time_point heard;
  };

  const std::string name_;
  const Now now_;
  std::optional<v1::ServerStatus> status_;
  std::uint64_t start_ = 0;
  Clock::time_point seen_{};
  /// Another server and when it was heard; the one to ask once the first is gone.
  std::optional<std::pair<v1::ServerStatus, Clock::time_point>> successor_;
  std::map<std::string, Other> others_;  ///< servers of other names
};

}  // namespace handgraft::idl::cyclone
