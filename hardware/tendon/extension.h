#pragma once

#include "hardware/tendon/motor_map.h"

namespace handgraft::tendon {

/// How far one joint pulls in one tendon that crosses it: e(q), e(0) = 0, positive when the
/// tendon gets shorter between its ends. Its slope is the moment arm r(q), signed.
///
/// Units: q rad, e m, slope m/rad.
/// Source: Murray, Li & Sastry 1994, "A Mathematical Introduction to Robotic Manipulation",
/// ch. 6.4 (extension functions).
class Extension {
 public:
  struct Value {
    double e;
    double slope;
    double curvature;
  };

  /// A pulley, or a bowstring of constant arm: e = r q.
  static Extension constantArm(double arm_m);

  /// A fit to measured pairs: e = r q + c q^2 / 2.
  static Extension quadratic(double arm_m, double curvature_m);

  /// Through two channels printed into neighbouring links: the tendon leaves the proximal one
  /// `before_m` before the joint axis and enters the distal one `after_m` behind it, both
  /// `height_m` on the palmar side of the axis. With A, B the exits' distances from the axis
  /// and g = pi - atan2(y, a) - atan2(y, b) - q the angle between them, the free length is
  /// sqrt(A^2 + B^2 - 2 A B cos g), a + b at q = 0.
  static Extension channel(double before_m, double after_m, double height_m);

  [[nodiscard]] Value at(double q) const;

  [[nodiscard]] bool isLinear() const { return kind_ == Kind::kConstant; }

  /// Of the slope over q in `range`, sampled finely (exact for the first two kinds).
  [[nodiscard]] Range slopes(const Range& range) const;

  /// Of e over q in `range`; exact where the slope keeps its sign.
  [[nodiscard]] Range excursions(const Range& range) const;

  /// The largest curvature over q in `range`, sampled finely.
  [[nodiscard]] double largestCurvature(const Range& range) const;

 private:
  enum class Kind { kConstant, kQuadratic, kChannel };

  Extension(Kind kind, double a, double b, double c) : kind_(kind), a_(a), b_(b), c_(c) {}

  Kind kind_;
  double a_, b_, c_;  // arm, curvature, -; or A, B, g at q = 0
};

}  // namespace handgraft::tendon
