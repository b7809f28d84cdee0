#include "hardware/bridge/report_line.h"

#include <cmath>
#include <string_view>

#include <fmt/format.h>

namespace handgraft::bridge {

namespace {

// Length of the UTF-8 sequence at the front of `text`; 0 if it is not one.
std::size_t utf8Length(std::string_view text) {
  const auto first = static_cast<unsigned char>(text.front());
  const std::size_t length = first < 0x80                    ? 1
                             : first >= 0xc2 && first < 0xe0 ? 2
                             : first >= 0xe0 && first < 0xf0 ? 3
                             : first >= 0xf0 && first < 0xf5 ? 4
                                                             : 0;
  if (length == 0 || length > text.size()) return 0;
  for (std::size_t i = 1; i < length; ++i) {
    if ((static_cast<unsigned char>(text[i]) & 0xc0) != 0x80) return 0;
  }
  // Overlong forms, surrogates and what lies above U+10FFFF.
  const unsigned char second = length > 1 ? static_cast<unsigned char>(text[1]) : 0;
  if ((first == 0xe0 && second < 0xa0) || (first == 0xed && second > 0x9f)) return 0;
  if ((first == 0xf0 && second < 0x90) || (first == 0xf4 && second > 0x8f)) return 0;
  return length;
}

std::string jsonString(std::string_view text) {
  std::string out = "\"";
  while (!text.empty()) {
    const std::size_t length = utf8Length(text);
    const char c = text.front();
    if (length == 0) {
      out += '?';
    } else if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (static_cast<unsigned char>(c) < 0x20) {
      out += fmt::format("\\u{:04x}", static_cast<unsigned>(c));
    } else {
      out += text.substr(0, length);
    }
    text.remove_prefix(length == 0 ? 1 : length);
  }
  return out + '"';
}

std::string jsonNumber(double value) {
  return std::isfinite(value) ? fmt::format("{:.6f}", value) : "null";
}

template <class Items, class Print>
std::string jsonArray(const Items& items, const Print& print) {
  std::string out = "[";
  for (const auto& item : items) {
    if (out.size() > 1) out += ',';
    out += print(item);
  }
  return out + ']';
}

}  // namespace

const char* nameOf(v1::BridgeState state) {
  switch (state) {
    case v1::BRIDGE_DISCONNECTED:
      return "disconnected";
    case v1::BRIDGE_IDLE:
      return "idle";
    case v1::BRIDGE_ARMED:
      return "armed";
    case v1::BRIDGE_HOLDING:
      return "holding";
    case v1::BRIDGE_FAULT:
      return "fault";
    case v1::BRIDGE_ESTOP:
      return "estop";
  }
  return "unknown";
}

std::string textLine(const BridgeReport& report) {
  return fmt::format("handgraft-bridge: {}: {}", nameOf(report.state), report.message);
}

std::string jsonLine(const BridgeReport& report) {
  return fmt::format(
      R"({{"message":{},"state":"{}","session_id":{},"hand":{},"names":{},"position_rad":{},)"
      R"("target_rad":{}}})",
      jsonString(report.message), nameOf(report.state), report.session_id,
      jsonString(report.hand), jsonArray(report.names, jsonString),
      jsonArray(report.position, jsonNumber), jsonArray(report.target, jsonNumber));
}

}  // namespace handgraft::bridge
