#pragma once

#include <optional>
#include <string>

namespace handgraft::hand {

/// A place on a hand that means the same on another hand.
///
/// On a digit: how far along one of its segments, and how far round it. On the palm: between
/// the fingers' knuckles and the wrist, and across from the first finger to the last; a web
/// lies beyond an end of the row.
struct HandLocation {
  std::string digit;      ///< `thumb`, `index`, ..., a hand's own name, or `palm`
  std::string segment;    ///< `proximal`, `middle`, `distal`; empty on the palm
  int segment_count = 0;  ///< of the digit it was taken from; 0: not known
  /// On a segment 0 at its base to 1 at its end; on the palm 0 at the knuckles to 1 at the
  /// wrist. May lie beyond where a segment's links reach farther than its bone.
  double along = 0.5;
  /// 0 palmar, positive towards the thumb's side, in (-pi, pi]; on the palm the way it faces.
  double around_rad = 0.0;
  double across = 0.5;  ///< on the palm: 0 at the first finger's knuckle, 1 at the last one's
  /// Way to the tip as a share of the digit's length; below 0: not known.
  double from_tip = -1.0;

  bool operator==(const HandLocation&) const = default;
};

inline constexpr const char* kPalmPart = "palm";

/// `index_proximal`, `palm`: what patches that touch there are called.
std::string partName(const std::string& digit, const std::string& segment);

/// The middle of the part that such a name, perhaps with a number behind (`index_middle_2`),
/// stands for; nothing for other names, nor for a digit's alone, which is its site's.
std::optional<HandLocation> placeNamed(const std::string& name);

}  // namespace handgraft::hand
