#pragma once

namespace handgraft::tendon {

/// A drum that winds a tendon. Each turn of line that lies on turns below raises the radius by
/// `growth_m`: d(angle) = d(e) / (r + growth e / (2 pi r)), whose integral is used exactly both
/// ways. The angle is 0 where the excursion is 0.
struct Spool {
  double radius_m = 0.01;
  double growth_m = 0;  ///< 0: turns lie side by side

  /// rad. Requires e above `leastExcursion`.
  [[nodiscard]] double angleAt(double e_m) const;
  /// m.
  [[nodiscard]] double excursionAt(double angle_rad) const;
  /// d(e)/d(angle), m/rad.
  [[nodiscard]] double radiusAt(double e_m) const;
  /// More cannot be paid out, m; -inf without growth.
  [[nodiscard]] double leastExcursion() const;
};

}  // namespace handgraft::tendon
