#include "client/editor/quantity.h"

#include <charconv>
#include <cmath>
#include <map>
#include <numbers>

namespace handgraft::client::editor {

namespace {

const std::map<std::string, Quantity> kUnits = {
    {"", {1.0, Unit::kNone}},
    {"rad", {1.0, Unit::kAngle}},
    {"deg", {std::numbers::pi / 180.0, Unit::kAngle}},
    {"m", {1.0, Unit::kLength}},
    {"cm", {0.01, Unit::kLength}},
    {"mm", {0.001, Unit::kLength}}};

}  // namespace

std::optional<Quantity> quantityOf(const std::string& text) {
  const char* begin = text.data();
  const char* end = begin + text.size();
  if (begin != end && *begin == '+') {
    ++begin;
    if (begin != end && *begin == '-') return std::nullopt;
  }
  double number = 0.0;
  const auto [rest, error] = std::from_chars(begin, end, number);
  if (error != std::errc() || !std::isfinite(number)) return std::nullopt;
  const auto unit = kUnits.find(std::string(rest, end));
  if (unit == kUnits.end()) return std::nullopt;
  return Quantity{number * unit->second.value, unit->second.unit};
}

std::optional<std::uint64_t> countOf(const std::string& text) {
  std::uint64_t number = 0;
  const char* end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, number);
  if (error != std::errc() || rest != end) return std::nullopt;
  return number;
}

}  // namespace handgraft::client::editor
