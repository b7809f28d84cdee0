#pragma once

#include <cstddef>
#include <limits>
#include <span>
#include <vector>

namespace handgraft::safety {

/// What one joint may do. Units: rad and seconds; metres stand for radians if it slides.
struct JointLimits {
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();
  double velocity = 2.0;
  double acceleration = 20.0;
  double jerk = 400.0;
  double margin = 1e-4;  ///< targets stay this far inside `lower` and `upper`
  bool slides = false;
  /// What it moves by for each radian of its motor, behind gears: 1 if it turns, m if it
  /// slides.
  double travel = 1.0;
};

/// The unit of its positions.
inline const char* unitOf(const JointLimits& joint) {
  return joint.slides ? "m" : "rad";
}

/// What held joints back in one period; all counts of joints.
struct LimiterActivity {
  std::size_t at_velocity = 0;      ///< as fast as they may be, on their way
  std::size_t at_acceleration = 0;  ///< wanted another velocity than could be had in a period
};

/// Turns any stream of target poses into positions that a motor may be sent: one position per
/// joint and period, smooth, and within position, velocity, acceleration and jerk limits
/// whatever the targets do. Joints move independently of each other.
///
/// Stage 1 moves at the highest velocity from which it can still stop at the target, so it
/// never overshoots a target that stands still, and never a limit. Stage 2 averages the last N
/// positions of stage 1, N = ceil(2 A / (J dt)): an average keeps position, velocity and
/// acceleration limits, and its third difference is at most 2 A / (N dt) <= J. The average
/// delays by (N - 1) dt / 2.
///
/// Guarantees, of the finite differences of what `step` returns, from `reset` on:
/// |velocity| <= V, |acceleration| <= A, |jerk| <= J up to rounding; every position lies within
/// [lower, upper], or between the position of the reset and that range if it started outside.
///
/// Differs: the usual braking curve, n (sqrt(1/4 + 2 D / (n dt)) - 1/2) with n = A dt,
/// overshoots by up to A dt^2 / 8 since it is exact for whole multiples of n only; ours
/// interpolates linearly between those, which is the exact answer for sampled motion.
///
/// Cost: O(joints) a step; no allocation after construction.
class JointLimiter {
 public:
  /// Needs a `reset` before the first `step`.
  /// Errors: InvalidInput for a period outside (0, 1] s, a limit that is not positive and
  /// finite, a range that is empty or NaN, or more than 65,536 taps (a jerk limit too low for
  /// the period).
  JointLimiter(std::vector<JointLimits> limits, double period_s);

  [[nodiscard]] std::size_t jointCount() const { return joints_.size(); }

  /// Forgets all motion and stands still at `measured` (rad, one per joint); the target is the
  /// same, inside the limits. Errors: InvalidInput, and nothing changes, if a value is not
  /// finite.
  void reset(std::span<const double> measured);

  /// New targets (rad, one per joint), each clamped into its limits; one that is not finite
  /// leaves that joint's target as it was. Ends braking.
  void aim(std::span<const double> targets);

  /// Stops every joint as fast as its limits allow, and holds it there until the next `aim`.
  void brake();

  /// From now on no joint moves faster than this share, in (0, 1], of its velocity limit;
  /// joints that do are slowed within their limits. A reset does not change it.
  void setSpeedShare(double share);

  /// Advances by one period; the positions to send (rad), valid until the next call.
  std::span<const double> step();

  /// `target` (rad, finite) as `aim` would take it for joint `joint`: inside its limits.
  [[nodiscard]] double allowed(std::size_t joint, double target) const;

  /// The targets as they were accepted, inside the limits.
  [[nodiscard]] std::span<const double> targets() const { return targets_; }

  /// What the last `step` or `reset` gave.
  [[nodiscard]] std::span<const double> positions() const { return positions_; }

  /// Of the last `step`.
  [[nodiscard]] const LimiterActivity& activity() const { return activity_; }

  /// The longest that `brake` can take joint `joint` to stand still, s.
  [[nodiscard]] double brakingTime(std::size_t joint) const;

  /// True once the positions have stopped changing and will not change without a new target.
  [[nodiscard]] bool atRest() const;

 private:
  struct Joint {
    JointLimits limits;
    double step_velocity = 0;  // n = A dt: the most that the velocity may change in a period
    double full_speed_distance =
        0;  // from here on the velocity limit decides, in units of n dt
    double lowest = 0, highest = 0;  // of targets
    double position = 0;             // of stage 1
    double velocity = 0;
    bool braking = false;
    std::size_t still_steps = 0;  // periods since stage 1 last moved, at most the taps
    std::vector<double> taps;     // ring of stage 1 positions
    std::size_t oldest = 0;
    double tap_sum = 0;
  };

  [[nodiscard]] double brakingVelocity(const Joint& joint, double distance) const;
  void advance(Joint& joint, double target);
  static double average(Joint& joint);

  double period_;
  double speed_share_ = 1;
  bool ready_ = false;
  LimiterActivity activity_;
  std::vector<Joint> joints_;
  std::vector<double> targets_;
  std::vector<double> positions_;
};

}  // namespace handgraft::safety
