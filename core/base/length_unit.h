#pragma once

#include <array>
#include <string_view>

namespace handgraft {

/// What lengths of a file, or of what is typed, may be in.
struct LengthUnit {
  std::string_view name;
  std::string_view plural;
  double metres;
};

inline constexpr std::array<LengthUnit, 4> kLengthUnits{{{"m", "metres", 1.0},
                                                         {"cm", "centimetres", 0.01},
                                                         {"mm", "millimetres", 0.001},
                                                         {"in", "inches", 0.0254}}};

/// nullptr if no unit has this name.
constexpr const LengthUnit* lengthUnitCalled(std::string_view name) {
  for (const LengthUnit& unit : kLengthUnits)
    if (unit.name == name) return &unit;
  return nullptr;
}

}  // namespace handgraft
