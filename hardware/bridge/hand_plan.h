#pragma once

#include <string>
#include <vector>

#include "hardware/config/hand_config.h"
#include "hardware/safety/joint_limiter.h"
#include "idl/models.h"

namespace handgraft::bridge {

/// How fast a hand may move where its model does not say, and never faster.
struct MotionBounds {
  double revolute_velocity = 2.0;  ///< rad/s: about 115 deg/s, a finger closes in one second
  double revolute_acceleration = 20.0;  ///< rad/s^2: full speed after 0.1 s
  double revolute_jerk = 400.0;         ///< rad/s^3: full acceleration after 0.05 s
  double prismatic_velocity = 0.1;      ///< m/s
  double prismatic_acceleration = 1.0;  ///< m/s^2
  double prismatic_jerk = 20.0;         ///< m/s^3
};

/// The joints of a hand as the bridge moves them, in the order of the hand's description.
struct HandPlan {
  std::string hand;
  std::vector<std::string> names;
  std::vector<safety::JointLimits> limits;
  std::vector<double> rest;  ///< inside the limits

  [[nodiscard]] std::size_t jointCount() const { return names.size(); }
};

/// Plans the motion of a hand from what the server says of it: the model's velocity limit where
/// there is one, but never more than `bounds`.
/// Errors: InvalidInput for no joints, more than 512, a name that is empty or twice, a range
/// that is empty or NaN, a negative velocity limit.
HandPlan planHand(const v1::HandDescription& description, const MotionBounds& bounds);

/// The config of a simulated hand that moves as planned: a motor a joint, and a governor that
/// is as patient as can be with a busy machine, since nobody can be hurt.
config::HandConfig simulatedConfig(const HandPlan& plan, double period_s);

/// How `config` differs from the hand's own model, for people; empty if it does not: joints
/// that only one of them has, limits that permit what the model's do not, and followers that
/// follow another way. What the config
/// forbids beyond that is its own affair.
std::string differencesOf(const v1::HandDescription& description,
                          const config::HandConfig& config);

/// Which joints slide by the one and turn by the other, for people; empty if none does. Limits
/// and thresholds of such a config mean nothing: nobody may be moved by it.
std::string kindsThatDiffer(const v1::HandDescription& description,
                            const config::HandConfig& config);

/// Where the motors of `simulatedConfig` stand when the hand rests, rad.
std::vector<double> restOfMotors(const HandPlan& plan);

/// Whether both are moved alike, so that a device made for one does for the other.
bool movesAlike(const HandPlan& a, const HandPlan& b);

}  // namespace handgraft::bridge
