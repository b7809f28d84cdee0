#include "hardware/tendon/spool.h"

#include <cmath>
#include <limits>
#include <numbers>

namespace handgraft::tendon {

namespace {
constexpr double kTurn = 2 * std::numbers::pi;
}  // namespace

double Spool::angleAt(double e_m) const {
  if (growth_m == 0) return e_m / radius_m;
  return kTurn * radius_m / growth_m *
         std::log1p(growth_m * e_m / (kTurn * radius_m * radius_m));
}

double Spool::excursionAt(double angle_rad) const {
  if (growth_m == 0) return angle_rad * radius_m;
  return kTurn * radius_m * radius_m / growth_m *
         std::expm1(growth_m * angle_rad / (kTurn * radius_m));
}

double Spool::radiusAt(double e_m) const {
  return radius_m + growth_m * e_m / (kTurn * radius_m);
}

double Spool::leastExcursion() const {
  if (growth_m == 0) return -std::numeric_limits<double>::infinity();
  return -kTurn * radius_m * radius_m / growth_m;
}

}  // namespace handgraft::tendon
