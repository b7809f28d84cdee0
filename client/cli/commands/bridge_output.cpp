#include "client/cli/commands/bridge_output.h"

#include <fmt/format.h>

#include "client/present/json_output.h"
#include "idl/fields.h"

namespace handgraft::client {

namespace {

std::string age(double seconds) {
  return seconds < 0 ? "never" : fmt::format("{:.2f} s ago", seconds);
}

std::string motorsText(const v1::BridgeStatus& bridge) {
  if (bridge.power() == v1::POWER_ON) return "under power";
  if (bridge.power() == v1::POWER_OFF) return "off";
  return bridge.state() == v1::BRIDGE_DISCONNECTED && bridge.fault() == v1::FAULT_NONE
             ? "not known whether they are off: there is no device"
             : "not known whether they are off: cut their power";
}

std::string paragraph(const v1::BridgeStatus& bridge) {
  std::string text = fmt::format("bridge {}: {}: {}\n", bridge.bridge_id(),
                                 v1::nameOf(bridge.state()), bridge.reason());
  const auto line = [&](const char* name, const std::string& what) {
    text += fmt::format("  {:<8}{}\n", name, what);
  };
  line("device", bridge.device() + (bridge.config().empty() ? "" : ", " + bridge.config()));
  line("hand", bridge.hand().empty() ? "none yet" : bridge.hand());
  if (bridge.fault() != v1::FAULT_NONE) line("fault", v1::nameOf(bridge.fault()));
  line("motors",
       fmt::format("{}, {}{}", motorsText(bridge), bridge.homed() ? "homed" : "not homed",
                   bridge.temperature_c() < 0
                       ? std::string()
                       : fmt::format(", {:.0f} degrees C", bridge.temperature_c())));
  line("stream",
       fmt::format("{}, alive {}, last pose {}; {} poses accepted, {} refused",
                   bridge.session_id() == 0 ? std::string("no session")
                                            : fmt::format("session {}", bridge.session_id()),
                   age(bridge.stream_age_s()), age(bridge.command_age_s()),
                   bridge.poses_accepted(), bridge.poses_refused()));
  if (!bridge.last_refusal().empty()) line("refused", bridge.last_refusal());
  if (!bridge.warnings().empty()) line("warning", bridge.warnings());
  if (!bridge.clamping().empty()) line("clamped", bridge.clamping());
  line("limits", fmt::format("targets clamped in {} periods, motion cut in {}",
                             bridge.clamped(), bridge.limited()));
  line("off by", fmt::format("{:.4f} rad from what was sent; {:.4f} rad that it cannot follow",
                             bridge.tracking_rad(), bridge.residual_rad()));
  line("loop",
       fmt::format("{:.4g} Hz, {} periods, {} late, at worst by {:.2f} ms{}",
                   bridge.period_s() > 0 ? 1 / bridge.period_s() : 0.0, bridge.periods(),
                   bridge.overruns(), 1000 * bridge.worst_lateness_s(),
                   bridge.realtime() ? ", real-time" : ""));
  line("wire", fmt::format("{} answers lost, {} bytes passed over", bridge.answers_lost(),
                           bridge.bytes_discarded()));
  return text;
}

}  // namespace

std::string powerNotKnownText(const v1::BridgeStatus& bridge) {
  return fmt::format(
      "bridge {} does as told, but its device may not have heard of it: whether the motors are "
      "off is not known, cut their power ({})",
      bridge.bridge_id(), bridge.reason());
}

std::string statusText(const std::vector<v1::BridgeStatus>& bridges) {
  std::string text;
  for (const v1::BridgeStatus& bridge : bridges)
    text += paragraph(bridge);
  return text;
}

std::string whyNotText(const v1::BridgeStatus& bridge) {
  if (bridge.last_refusal().empty()) return bridge.reason();
  // The state says the same of zeros as the refusal does.
  if (bridge.refusal() == v1::REFUSAL_NOT_HOMED) return bridge.last_refusal();
  return bridge.reason() + "; " + bridge.last_refusal();
}

std::string statusJson(const std::vector<v1::BridgeStatus>& bridges) {
  json::Json list = json::Json::array();
  for (const v1::BridgeStatus& bridge : bridges)
    list.push_back(json::jsonOf(bridge));
  return json::written({{"bridges", list}}, 2);
}

}  // namespace handgraft::client
