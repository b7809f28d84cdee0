#include "idl/cyclone/known_server.h"

#include <algorithm>

#include "core/base/utf8.h"

namespace handgraft::idl::cyclone {

namespace {

using std::chrono::milliseconds;

constexpr milliseconds kFirstAnswer(2000);  // a server that lives says so once a second
constexpr milliseconds kLost(3000);         // three missed, on a machine that may be busy
constexpr std::size_t kMostOthers = 64;     // servers of other names that are remembered

/// What came over the wire, for a message of one line.
std::string plainName(const std::string& name) {
  constexpr std::size_t kLongest = 64;
  return onOneLine(name, kLongest);
}

}  // namespace

void KnownServer::hear(const v1::ServerStatus& message) {
  if (message.name() != name_) {
    others_[message.name()] = {message.host(),
                               message.stopping() ? Clock::time_point{} : now_()};
    if (others_.size() > kMostOthers) others_.erase(others_.begin());
    return;
  }
  if (status_ && !isIt(message.server_id())) {
    if (!message.stopping()) successor_.emplace(message, now_());
  } else {
    // One on its store is the same one, started again.
    if (!status_ || message.uptime_s() < status_->uptime_s()) ++start_;
    status_ = message;
    seen_ = now_();
  }
  succeed();
}

void KnownServer::forgive(Clock::duration held_up) {
  seen_ = std::min(now_(), seen_ + held_up);
}

void KnownServer::succeed() {
  if (!successor_ || isAlive()) return;
  auto [next, heard] = *std::exchange(successor_, std::nullopt);
  if (now_() - heard >= kLost) return;
  status_ = std::move(next);
  seen_ = heard;
  ++start_;
}

bool KnownServer::isAlive() const {
  return status_ && !status_->stopping() && now_() - seen_ < kLost;
}

KnownServer::Clock::duration KnownServer::silenceSince(Clock::time_point begun) const {
  return now_() - std::max(seen_, begun);
}

void KnownServer::requireSameVersion() const {
  if (!status_ || status_->protocol_version() == v1::PROTOCOL_VERSION) return;
  throw Refused(
      v1::ERROR_VERSION,
      fmt::format("the server ({}) speaks protocol {}, this program speaks {}",
                  status_->version(), status_->protocol_version(), v1::PROTOCOL_VERSION));
}

std::exception_ptr KnownServer::lossSince(Clock::time_point begun,
                                          std::uint64_t server_id,
                                          const Participant& on) const {
  try {
    requireSameVersion();
    if (server_id != 0 && status_ && !isIt(server_id)) {
      throw Refused(v1::ERROR_OTHER_SERVER,
                    fmt::format("handgraft-server {} on {} is gone, and its sessions with it; "
                                "another one ({}) answers",
                                server_id, describe(on.network()), status_->server_id()));
    }
    if (isAlive() || now_() - begun < kFirstAnswer) return nullptr;
    if (!status_) throw none(on);
    throw NoServer(fmt::format("handgraft-server on {} {}", describe(on.network()),
                               status_->stopping() ? "is stopping" : "stopped answering"));
  } catch (...) {
    return std::current_exception();
  }
}

NoServer KnownServer::none(const Participant& on) const {
  std::string there;
  for (const auto& [name, other] : others_) {
    if (now_() - other.heard > kLost) continue;
    there += fmt::format("{}{} on {}", there.empty() ? "" : ", ",
                         name.empty() ? "one without a name" : "--server " + plainName(name),
                         plainName(other.host));
  }
  std::string text = fmt::format("no handgraft-server{} answers on {}",
                                 there.empty() || !name_.empty() ? "" : " without a name",
                                 describe(on.network()));
  if (!there.empty()) text += "; there is " + there;
  if (on.identity()) {
    text +=
        "; one that is open, of another authority, or that knows this identity as revoked does "
        "not";
  } else if (on.isKeptOut()) {
    text += "; a secured program is there, which takes an identity to meet (--identity)";
  }
  return NoServer(text);
}

}  // namespace handgraft::idl::cyclone
