#include "server/reading/units.h"

#include <array>
#include <optional>

namespace handgraft::server {

namespace {

struct Unit {
  const char* name;
  const char* words;
  double metres;
};

/// In the order of likelihood, metres apart.
constexpr std::array<Unit, 3> kOthers{
    {{"mm", "millimetres", 1e-3}, {"cm", "centimetres", 1e-2}, {"in", "inches", 0.0254}}};

constexpr double kSmallestObject_m = 0.001;
constexpr double kLargestObject_m = 10.0;

std::string lengthText(double length_m) {
  return length_m < 1.0 ? fmt::format("{:.3g} mm", 1e3 * length_m)
                        : fmt::format("{:.4g} m", length_m);
}

/// The unit that makes an object of a hand's size of it, or at least one that it could be.
const Unit* likelyUnit(double size) {
  for (const auto& [least_m, most_m] : {std::pair(0.02, 0.6), std::pair(0.005, 3.0)}) {
    for (const Unit& unit : kOthers) {
      if (size * unit.metres >= least_m && size * unit.metres <= most_m) return &unit;
    }
  }
  return nullptr;
}

/// Throws UnitsInDoubt if other units would make sense.
void doubt(double size, const std::string& name) {
  const Unit* likely = likelyUnit(size);
  if (likely == nullptr) return;
  throw UnitsInDoubt(fmt::format("{}: {} across as metres; as {} {}: say --units {}", name,
                                 lengthText(size), likely->words,
                                 lengthText(size * likely->metres), likely->name));
}

}  // namespace

double metresPer(const std::string& units) {
  if (units.empty() || units == "m") return 1.0;
  for (const Unit& unit : kOthers) {
    if (units == unit.name) return unit.metres;
  }
  rejectInput("units {} are not known; permitted are m, cm, mm and in",
              handgraft::quoted(units));
}

double objectScale(double size, const std::string& units, const std::string& name) {
  const double scale = metresPer(units);
  if (units.empty() && size > kLargestUnasked_m) doubt(size, name);
  const double size_m = scale * size;
  if (!(size_m >= kSmallestObject_m && size_m <= kLargestObject_m)) {
    rejectInput("{}: {} across{}; permitted are {} to {}", name, lengthText(size_m),
                units.empty() ? " as metres" : " in the units given, " + units,
                lengthText(kSmallestObject_m), lengthText(kLargestObject_m));
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
  if (!units.empty()) return {own, ""};
  if (size > kLargestUnasked_m) doubt(size, name);
  return {1.0, ""};
}

}  // namespace handgraft::server
