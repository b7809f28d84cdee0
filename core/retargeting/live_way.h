#pragma once

#include <Eigen/Core>

#include "core/hand/kinematics.h"

namespace handgraft::retargeting {

/// A hand's way from where it is to a pose that was found elsewhere: about the object, and away
/// from it in between. As long as it takes at 0.25 m/s and 3 rad/s on average, 0.2 to 0.8 s.
/// Then it lets the hand go within 0.25 s: what has begun to touch meanwhile would else take it
/// from there in one frame.
class LiveWay {
 public:
  /// Frames: O. `middle_O`: of the object.
  LiveWay(const hand::HandPose& from_O,
          const hand::HandPose& to_O,
          const Eigen::Vector3d& middle_O,
          double begin_s);

  /// Before it begins its beginning, behind its end its end.
  [[nodiscard]] hand::HandPose at(double time_s) const;

  [[nodiscard]] double end() const { return begin_s_ + duration_s_; }

  /// How firmly it holds the hand: 1 to its end, then ever less, 0 once it has let go.
  [[nodiscard]] double firmness(double time_s) const;

 private:
  /// Round the object and farther out in its middle.
  struct Arc {
    Arc(const Eigen::Vector3d& from, const Eigen::Vector3d& to);

    [[nodiscard]] Eigen::Vector3d at(double share) const;
    [[nodiscard]] double length() const;

    Eigen::Vector3d direction;  ///< of its beginning, unit
    Eigen::Vector3d axis;
    double angle = 0.0;  ///< rad
    double begin = 0.0;  ///< m from the middle
    double end = 0.0;
    double farther = 0.0;  ///< m, half-way
  };

  hand::HandPose from_O_;
  hand::HandPose to_O_;
  Eigen::Vector3d middle_O_;
  Arc arc_;
  double begin_s_ = 0.0;
  double duration_s_ = 0.0;
};

}  // namespace handgraft::retargeting
