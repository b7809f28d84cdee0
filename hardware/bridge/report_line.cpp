#include "hardware/bridge/report_line.h"

#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "idl/fields.h"

namespace handgraft::bridge {

std::string textLine(const BridgeReport& report) {
  return fmt::format("handgraft-bridge: {}: {}", nameOf(report.state), report.message);
}

std::string jsonLine(const BridgeReport& report) {
  using Json = nlohmann::ordered_json;
  const Json line = {{"message", report.message},       {"state", nameOf(report.state)},
                     {"session_id", report.session_id}, {"hand", report.hand},
                     {"names", report.names},           {"position", report.position},
                     {"target", report.target}};
  return line.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace handgraft::bridge
