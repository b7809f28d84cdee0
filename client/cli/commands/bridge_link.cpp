#include "client/cli/commands/bridge_link.h"

#include <algorithm>

#include "core/base/error.h"
#include "core/base/random_id.h"
#include "idl/topics.h"

namespace handgraft::client {

namespace {

using std::chrono::milliseconds;

constexpr milliseconds kTick(20);
constexpr milliseconds kRepeat(200);
constexpr milliseconds kSearch(2000);
constexpr milliseconds kMore(300);          // for others after the first
constexpr std::chrono::seconds kDeaf(3);    // for a bridge that is heard to be seen listening
constexpr std::chrono::seconds kSilent(3);  // thirty statuses missed

}  // namespace

BridgeLink::BridgeLink(const Network& network, Interruption& interruption)
    : network_(network),
      interruption_(interruption),
      participant_(network, idl::cyclone::Discovers::kNoClients),
      statuses_(participant_, idl::kBridgeStatusTopic),
      commands_(participant_, idl::kHandCommandTopic) {
  // Soon, so that bridges listen when a command comes; others still may look.
  const auto& identity = participant_.identity();
  if (!identity || identity->role == idl::security::Role::kOperator) commands_.get();
}

void BridgeLink::take() {
  interruption_.checkpoint();
  statuses_.wait(kTick);
  statuses_.take([this](const v1::BridgeStatus& status) {
    bridges_[status.bridge_id()] = status;
    heard_[status.bridge_id()] = Clock::now();
  });
}

// Nobody waits for a bridge that cannot answer.
void BridgeLink::requireAlive(std::uint32_t bridge_id, Clock::time_point since) {
  const Clock::time_point now = Clock::now();
  const std::string where = handgraft::describe(network_);
  if (now - std::max(since, heard_[bridge_id]) > kSilent) {
    throw TransportError(fmt::format(
        "bridge {} on {} has fallen silent: it tells no status any more", bridge_id, where));
  }
  if (now - since > kDeaf && commands_.get().readers() == 0) {
    throw TransportError(
        fmt::format("bridge {} is heard on {}, but does not listen to commands from here: what "
                    "this machine sends does not arrive there; handgraft doctor may tell why",
                    bridge_id, where));
  }
}

std::vector<v1::BridgeStatus> BridgeLink::all() {
  const Clock::time_point start = Clock::now();
  std::optional<Clock::time_point> first;
  while (Clock::now() - start < kSearch && (!first || Clock::now() - *first < kMore)) {
    take();
    if (!first && !bridges_.empty()) first = Clock::now();
  }
  return known();
}

std::vector<v1::BridgeStatus> BridgeLink::known() const {
  if (bridges_.empty())
    throw TransportError(
        fmt::format("no handgraft-bridge answers on {}", handgraft::describe(network_)));
  std::vector<v1::BridgeStatus> found;
  for (const auto& [id, status] : bridges_)
    found.push_back(status);
  return found;
}

v1::BridgeStatus BridgeLink::one(const std::optional<std::uint32_t>& bridge_id) {
  const std::vector<v1::BridgeStatus> found = all();
  if (!bridge_id && found.size() == 1) return found.front();
  std::string ids;
  for (const v1::BridgeStatus& status : found) {
    if (bridge_id == status.bridge_id()) return status;
    ids += (ids.empty() ? "" : ", ") + std::to_string(status.bridge_id());
  }
  if (bridge_id) rejectInput("--bridge {}: there is {}", *bridge_id, ids);
  rejectInput("there are bridges {}: say which with --bridge", ids);
}

v1::BridgeStatus BridgeLink::command(
    std::uint32_t bridge_id,
    v1::HandCommandKind kind,
    std::chrono::seconds patience,
    const std::function<bool(const v1::BridgeStatus&)>& is_done) {
  const v1::HandCommand message = make(bridge_id, kind);
  const Clock::time_point start = Clock::now();
  Clock::time_point due = start;
  while (Clock::now() - start < patience) {
    requireAlive(bridge_id, start);
    if (Clock::now() >= due) {
      commands_.get().write(message);
      due = Clock::now() + repeat();
    }
    take();
    if (is_done(bridges_[bridge_id])) return bridges_[bridge_id];
  }
  throw TransportError(fmt::format(
      "bridge {} on {} has not answered within {} s: whether it will do it is not known",
      bridge_id, handgraft::describe(network_), patience.count()));
}

std::vector<v1::BridgeStatus> BridgeLink::stop(
    const std::optional<std::uint32_t>& bridge_id,
    std::chrono::seconds patience,
    const std::function<bool(const v1::BridgeStatus&)>& is_done) {
  struct Order {
    v1::HandCommand message;
    Clock::time_point due;
  };

  std::map<std::uint32_t, Order> orders;
  const Clock::time_point start = Clock::now();
  std::optional<Clock::time_point> first;
  while (Clock::now() - start < patience) {
    take();
    bool are_done = !orders.empty();
    for (const auto& [id, status] : bridges_) {
      if (bridge_id && id != *bridge_id) continue;
      const auto [order, is_new] =
          orders.try_emplace(id, Order{make(id, v1::COMMAND_ESTOP), Clock::now()});
      const bool is_owed = is_new || !is_done(status);  // told once in any case
      if (is_owed && Clock::now() >= order->second.due) {
        commands_.get().write(order->second.message);
        order->second.due = Clock::now() + repeat();
      }
      are_done = are_done && is_done(status);
    }
    if (!first && !orders.empty()) first = Clock::now();
    if (first && are_done && (bridge_id || Clock::now() - *first >= kMore)) break;
    if (!first && Clock::now() - start >= kSearch) break;
  }
  if (bridge_id) return {one(bridge_id)};
  return known();
}

v1::HandCommand BridgeLink::make(std::uint32_t bridge_id, v1::HandCommandKind kind) const {
  v1::HandCommand message;
  message.bridge_id(bridge_id);
  message.command_id(randomId());
  message.kind(kind);
  return message;
}

// A command is not kept for those that come later: until somebody listens, it is soon said
// again.
milliseconds BridgeLink::repeat() {
  return commands_.get().readers() > 0 ? kRepeat : kTick;
}

v1::BridgeStatus BridgeLink::news(std::uint32_t bridge_id) {
  requireAlive(bridge_id, heard_[bridge_id]);
  take();
  return bridges_[bridge_id];
}

}  // namespace handgraft::client
