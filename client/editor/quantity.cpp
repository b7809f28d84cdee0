#include "client/editor/quantity.h"

#include <charconv>
#include <cmath>
#include <numbers>
#include <string_view>

#include "core/base/length_unit.h"

namespace handgraft::client::editor {

namespace {

/// What a number is to be multiplied with, and what it is then.
std::optional<Quantity> unitCalled(std::string_view name) {
  if (name.empty()) return Quantity{1.0, Unit::kNone};
  if (name == "rad") return Quantity{1.0, Unit::kAngle};
  if (name == "deg") return Quantity{std::numbers::pi / 180.0, Unit::kAngle};
  if (const LengthUnit* length = lengthUnitCalled(name))
    return Quantity{length->metres, Unit::kLength};
  return std::nullopt;
}

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
  const auto unit = unitCalled({rest, static_cast<std::size_t>(end - rest)});
  if (!unit) return std::nullopt;
  return Quantity{number * unit->value, unit->unit};
}

std::optional<std::uint64_t> countOf(const std::string& text) {
  std::uint64_t number = 0;
  const char* end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, number);
  if (error != std::errc() || rest != end) return std::nullopt;
  return number;
}

}  // namespace handgraft::client::editor
