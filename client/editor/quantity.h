#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace handgraft::client::editor {

enum class Unit { kNone, kAngle, kLength };

/// A number as it is written: `0.4`, `+15deg`, `-3mm`.
struct Quantity {
  double value = 0.0;  ///< rad or m where a unit was written
  Unit unit = Unit::kNone;
};

/// Units: rad, deg, and kLengthUnits. Nothing if `text` is no finite number with one of them or
/// none.
std::optional<Quantity> quantityOf(const std::string& text);

/// A whole number from 0 to 2^64 - 1.
std::optional<std::uint64_t> countOf(const std::string& text);

}  // namespace handgraft::client::editor
