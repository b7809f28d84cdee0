#include "server/reading/units.h"

#include <array>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/ranges.h>

#include "core/base/length_unit.h"

namespace handgraft::server {

namespace {

/// By likelihood, metres apart.
constexpr std::array<std::string_view, 3> kOthers{"mm", "cm", "in"};

constexpr double kSmallestObject = 0.001;  // m
constexpr double kLargestObject = 10.0;    // m

std::string lengthText(double length_m) {
  return length_m < 1.0 ? fmt::format("{:.3g} mm", 1e3 * length_m)
                        : fmt::format("{:.4g} m", length_m);
}

/// The units that make an object of a hand's size of it, or at least one that it could be.
std::vector<LengthUnit> likelyUnits(double size) {
  std::vector<LengthUnit> likely;
  for (const auto& [least_m, most_m] : {std::pair(0.02, 0.6), std::pair(0.005, 3.0)}) {
    for (const std::string_view name : kOthers) {
      const LengthUnit& unit = *lengthUnitCalled(name);
      if (size * unit.metres >= least_m && size * unit.metres <= most_m) likely.push_back(unit);
    }
    if (!likely.empty()) break;
  }
  return likely;
}

/// The units that would make an object of a hand's size of it instead; empty: none would.
std::string betterThan(const std::string& units, double size) {
  std::string better;
  for (const LengthUnit& unit : kLengthUnits) {
    const double size_m = size * unit.metres;
    if (unit.name == units || !(size_m >= 0.02 && size_m <= 0.6)) continue;
    better += fmt::format("{}--units {} ({})", better.empty() ? "; say " : " or ", unit.name,
                          lengthText(size_m));
  }
  return better;
}

/// Throws UnitsInDoubt if other units would make sense.
void doubt(double size, const std::string& name) {
  std::string sizes;
  std::string options;
  for (const LengthUnit& unit : likelyUnits(size)) {
    sizes += fmt::format("{}as {} {}", sizes.empty() ? "" : ", ", unit.plural,
                         lengthText(size * unit.metres));
    options += fmt::format("{}--units {}", options.empty() ? "" : " or ", unit.name);
  }
  if (sizes.empty()) return;
  throw UnitsInDoubt(fmt::format("{}: {} across as metres; {}: say {}", name, lengthText(size),
                                 sizes, options));
}

}  // namespace

double metresPer(const std::string& units) {
  if (units.empty()) return 1.0;
  if (const LengthUnit* unit = lengthUnitCalled(units)) return unit->metres;
  std::vector<std::string_view> names;
  names.reserve(std::size(kLengthUnits));
  for (const LengthUnit& unit : kLengthUnits)
    names.push_back(unit.name);
  rejectInput("units {} are not known; permitted are {}", handgraft::quoted(units),
              fmt::join(names, ", "));
}

double objectScale(double size, const std::string& units, const std::string& name) {
  const double scale = metresPer(units);
  if (units.empty() && size > kLargestUnasked) doubt(size, name);
  const double size_m = scale * size;
  if (!(size_m >= kSmallestObject && size_m <= kLargestObject)) {
    rejectInput("{}: {} across{}; permitted are {} to {}{}", name, lengthText(size_m),
                units.empty() ? " as metres" : " in the units given, " + units,
                lengthText(kSmallestObject), lengthText(kLargestObject),
                units.empty() ? "" : betterThan(units, size));
  }
  return scale;
}

MapScale mapScale(double size,
                  const std::string& units,
                  const std::string& object_units,
                  double object_m,
                  const std::string& name) {
  constexpr double kLeast = 0.01;
  constexpr double kMost = 1.5;
  constexpr double kLeastOfAll = 0.5;  // a map of the whole object; no two units permit it
  const auto fits = [&](double scale) {
    return scale * size >= kLeast * object_m && scale * size <= kMost * object_m;
  };
  const double own = metresPer(units.empty() ? object_units : units);
  if (fits(own)) return {own, ""};
  if (fits(1.0)) {
    return {1.0, fmt::format("the map is taken as metres, though units {} were given: it is {} "
                             "across, the object {}",
                             units.empty() ? object_units : units, lengthText(size),
                             lengthText(object_m))};
  }
  if (units.empty()) {
    if (size > kLargestUnasked) doubt(size, name);
    return {1.0, ""};
  }
  for (const std::string_view other : kOthers) {
    const LengthUnit& unit = *lengthUnitCalled(other);
    const double share = unit.metres * size / object_m;
    if (share < kLeastOfAll || share > kMost) continue;
    return {unit.metres,
            fmt::format("the map is taken as {}: it is {} across so, the object {}",
                        unit.plural, lengthText(unit.metres * size), lengthText(object_m))};
  }
  return {own, ""};
}

}  // namespace handgraft::server
