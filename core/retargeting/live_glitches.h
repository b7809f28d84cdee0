#pragma once

#include <optional>

#include "core/manipulation/contact_tracker.h"

namespace handgraft::retargeting {

/// Frames of a demonstrator's joints that no hand can have made: one of them farther from the
/// wrist, within a frame, than it goes at 2.5 m/s, and 5 mm, or the wrist itself than at 10
/// m/s, and 2 cm. Two in a row are passed over; what stays so for longer is where the hand is.
class LiveGlitches {
 public:
  /// Of a frame that jumps, the last one that did not; null: this one does not. Frames that are
  /// not finite are for others to refuse.
  const manipulation::DemonstratedFrame* steadyBefore(
      const manipulation::DemonstratedFrame& frame);

  /// This one did not.
  void takeSteady(const manipulation::DemonstratedFrame& frame);

 private:
  [[nodiscard]] bool jumps(const manipulation::DemonstratedFrame& frame) const;

  std::optional<manipulation::DemonstratedFrame> steady_;
  int jumped_ = 0;
};

}  // namespace handgraft::retargeting
