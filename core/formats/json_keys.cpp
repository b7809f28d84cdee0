#include "core/formats/json_keys.h"

#include <algorithm>
#include <cmath>

#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "core/base/error.h"

namespace handgraft::formats {

namespace {

constexpr std::string_view kNan = "NaN";

/// NaN outside of texts becomes null.
std::string withoutNan(std::string_view text) {
  std::string plain;
  bool is_in_text = false;
  for (std::size_t at = 0; at < text.size(); ++at) {
    if (!is_in_text && text.substr(at, kNan.size()) == kNan) {
      plain += "null";
      at += kNan.size() - 1;
      continue;
    }
    plain += text[at];
    if (text[at] == '"') is_in_text = !is_in_text;
    if (is_in_text && text[at] == '\\' && at + 1 < text.size()) plain += text[++at];
  }
  return plain;
}

}  // namespace

nlohmann::json parsedJson(std::string_view text) {
  // Nearly all files have none, and some are large.
  if (text.find(kNan) == std::string_view::npos) return nlohmann::json::parse(text);
  return nlohmann::json::parse(withoutNan(text));
}

std::optional<std::string> unknownKeyIn(const nlohmann::json& value,
                                        std::initializer_list<const char*> permitted) {
  if (!value.is_object()) return std::nullopt;
  for (const auto& [key, field] : value.items()) {
    if (std::find(permitted.begin(), permitted.end(), key) != permitted.end()) continue;
    return fmt::format("field {} is unknown; permitted are {}", handgraft::quoted(key),
                       fmt::join(permitted, " "));
  }
  return std::nullopt;
}

std::string shown(const nlohmann::json& value) {
  if (value.is_structured()) return fmt::format("an {}", value.type_name());
  // JSON has no infinity, and writes null.
  if (value.is_number_float() && !std::isfinite(value.get<double>()))
    return handgraft::quoted(fmt::format("{}", value.get<double>()));
  return handgraft::quoted(value.dump());
}

const nlohmann::json& memberOf(const nlohmann::json& value, const char* name) {
  const auto found = value.find(name);  // the end of what is no object
  if (found == value.end()) rejectInput("field '{}' is missing", name);
  return *found;
}

double finiteFrom(const nlohmann::json& value, const char* name) {
  if (!value.is_number() || !std::isfinite(value.get<double>()))
    rejectInput("field '{}' is {}; it must be a finite number", name, shown(value));
  return value.get<double>();
}

}  // namespace handgraft::formats
