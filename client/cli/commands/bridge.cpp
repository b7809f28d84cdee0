#include <cstdio>

#include <fmt/format.h>

#include "client/cli/commands/bridge_link.h"
#include "client/cli/commands/bridge_output.h"
#include "client/cli/commands/commands.h"
#include "client/present/interruption.h"
#include "core/base/error.h"
#include "idl/fields.h"

namespace handgraft::client {

namespace {

using Action = BridgeOptions::Action;

constexpr std::chrono::seconds kPatience(10);

bool isOff(const v1::BridgeStatus& bridge) {
  return bridge.power() != v1::POWER_ON && bridge.state() != v1::BRIDGE_ARMED &&
         bridge.state() != v1::BRIDGE_HOLDING;
}

v1::HandCommandKind kindOf(Action action) {
  switch (action) {
    case Action::kArm:
      return v1::COMMAND_ARM;
    case Action::kDisarm:
      return v1::COMMAND_DISARM;
    case Action::kReset:
      return v1::COMMAND_RESET;
    case Action::kHome:
      return v1::COMMAND_HOME;
    case Action::kStatus:
    case Action::kEstop:
      break;
  }
  return v1::COMMAND_ESTOP;
}

bool isDone(Action action, const v1::BridgeStatus& bridge) {
  switch (action) {
    case Action::kArm:
      return bridge.state() == v1::BRIDGE_ARMED && bridge.power() == v1::POWER_ON;
    case Action::kDisarm:
      return isOff(bridge);
    case Action::kReset:
      return bridge.state() == v1::BRIDGE_IDLE || bridge.state() == v1::BRIDGE_DISCONNECTED;
    case Action::kHome:
      return bridge.homed() && !bridge.homing();
    case Action::kEstop:
      return bridge.state() == v1::BRIDGE_ESTOP && bridge.power() != v1::POWER_ON;
    case Action::kStatus:
      return true;
  }
  return true;
}

/// Tells a command's refusal that is news from one of long ago, though it say the same. Poses
/// are refused meanwhile, too, which answers nobody.
class RefusalWatch {
 public:
  explicit RefusalWatch(const v1::BridgeStatus& before) : count_(before.refusal_count()) {}

  bool sees(const v1::BridgeStatus& bridge) {
    if (bridge.refusal_count() == count_) return false;
    count_ = bridge.refusal_count();
    return bridge.refusal() != v1::REFUSAL_NONE && bridge.refusal() != v1::REFUSAL_POSE;
  }

 private:
  std::uint64_t count_;
};

// A bridge that did as told may find that it cannot be done.
bool hasFailed(Action action, const v1::BridgeStatus& bridge, const v1::BridgeStatus& before) {
  const bool is_latched =
      bridge.state() == v1::BRIDGE_FAULT || bridge.state() == v1::BRIDGE_ESTOP;
  return action == Action::kArm && is_latched && bridge.state() != before.state();
}

// Homing begins by saying so, and takes as long as motors run; whether it was done shows then.
v1::BridgeStatus home(BridgeLink& link, const v1::BridgeStatus& before) {
  const std::uint32_t id = before.bridge_id();
  RefusalWatch refusals(before);
  const auto begins = [&](const v1::BridgeStatus& bridge) {
    return bridge.homing() || refusals.sees(bridge);
  };
  v1::BridgeStatus bridge = link.command(id, v1::COMMAND_HOME, kPatience, begins);
  if (!bridge.homing()) {
    throw DeviceError(
        fmt::format("bridge {}{}: {}", id, bridge.homed() ? "" : " is not homed",
                    bridge.last_refusal().empty() ? bridge.reason() : bridge.last_refusal()));
  }
  while (bridge.homing())
    bridge = link.news(id);
  return bridge;
}

v1::BridgeStatus act(BridgeLink& link, Action action, const v1::BridgeStatus& before) {
  if (action == Action::kHome) return home(link, before);
  RefusalWatch refusals(before);
  const auto is_answered = [&](const v1::BridgeStatus& bridge) {
    return isDone(action, bridge) || refusals.sees(bridge) || hasFailed(action, bridge, before);
  };
  return link.command(before.bridge_id(), kindOf(action), kPatience, is_answered);
}

}  // namespace

int run(const BridgeOptions& options, const CommonOptions& common, Interruption& interruption) {
  BridgeLink link(common.network, interruption);
  std::vector<v1::BridgeStatus> bridges;
  if (options.action == Action::kEstop) {
    bridges = link.stop(options.bridge_id, kPatience, [](const v1::BridgeStatus& bridge) {
      return isDone(Action::kEstop, bridge);
    });
  } else if (options.action != Action::kStatus) {
    bridges = {act(link, options.action, link.one(options.bridge_id))};
  } else if (options.bridge_id) {
    bridges = {link.one(options.bridge_id)};
  } else {
    bridges = link.all();
  }
  bool is_done = true;
  for (const v1::BridgeStatus& bridge : bridges)
    is_done = is_done && isDone(options.action, bridge);
  fmt::print("{}", common.json ? statusJson(bridges) + "\n" : statusText(bridges));
  const bool switches_off =
      options.action == Action::kEstop || options.action == Action::kDisarm;
  for (const v1::BridgeStatus& bridge : bridges) {
    if (!isDone(options.action, bridge)) {
      fmt::print(stderr, "handgraft: bridge {} did not do it: {}\n", bridge.bridge_id(),
                 whyNotText(bridge));
    } else if (switches_off && bridge.power() == v1::POWER_UNKNOWN) {
      // Who scripts a stop must not take it for one.
      is_done = false;
      fmt::print(stderr, "handgraft: {}\n", powerNotKnownText(bridge));
    }
  }
  return is_done ? 0 : 1;
}

}  // namespace handgraft::client
