#include "core/retargeting/live_way.h"

#include <algorithm>
#include <numbers>

#include <Eigen/Geometry>

#include "core/base/pose.h"
#include "core/manipulation/trajectory.h"

namespace handgraft::retargeting {

namespace {

constexpr double kSpeed = 0.25;        // m/s
constexpr double kTurning = 3.0;       // rad/s, of the hand and of its joints
constexpr double kShortest = 0.2;      // s
constexpr double kLongest = 0.8;       // s
constexpr double kLetsGo = 0.25;       // s
constexpr double kFarthestAway = 0.1;  // m, of a way by a radian or more

}  // namespace

LiveWay::Arc::Arc(const Eigen::Vector3d& from, const Eigen::Vector3d& to)
    : direction(from.normalized()), begin(from.norm()), end(to.norm()) {
  const Eigen::AngleAxisd turn(Eigen::Quaterniond::FromTwoVectors(from, to));
  axis = turn.axis();
  angle = turn.angle();
  farther = kFarthestAway * std::min(1.0, angle);
}

Eigen::Vector3d LiveWay::Arc::at(double share) const {
  const double distance =
      (1.0 - share) * begin + share * end + farther * std::sin(std::numbers::pi * share);
  return distance * (Eigen::AngleAxisd(share * angle, axis) * direction);
}

/// From above: both ways out and back, and about.
double LiveWay::Arc::length() const {
  return angle * 0.5 * (begin + end) + std::abs(end - begin) + 2.0 * farther;
}

LiveWay::LiveWay(const hand::HandPose& from_O,
                 const hand::HandPose& to_O,
                 const Eigen::Vector3d& middle_O,
                 double begin_s)
    : from_O_(from_O),
      to_O_(to_O),
      middle_O_(middle_O),
      arc_(from_O.X_WH.translation() - middle_O, to_O.X_WH.translation() - middle_O),
      begin_s_(begin_s) {
  const double turn =
      vectorFromRotation(to_O.X_WH.linear() * from_O.X_WH.linear().transpose()).norm();
  const double bend = (to_O.q - from_O.q).lpNorm<Eigen::Infinity>();
  duration_s_ = std::clamp(std::max(arc_.length() / kSpeed, std::max(turn, bend) / kTurning),
                           kShortest, kLongest);
}

hand::HandPose LiveWay::at(double time_s) const {
  const double share = std::clamp((time_s - begin_s_) / duration_s_, 0.0, 1.0);
  hand::HandPose pose = manipulation::poseBetween(from_O_, to_O_, share);
  pose.X_WH.translation() = middle_O_ + arc_.at(share);
  return pose;
}

double LiveWay::firmness(double time_s) const {
  return 1.0 - std::clamp((time_s - end()) / kLetsGo, 0.0, 1.0);
}

}  // namespace handgraft::retargeting
