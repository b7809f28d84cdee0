#pragma once

#include <string>

#include <Eigen/Dense>

#include "hardware/tendon/motor_map.h"

namespace handgraft::tendon {

/// Joints that move together, one motor each group: q = q0 + S s, with a motor angle s per
/// column of S. Direct drive, mimic joints and postural synergies are all of this kind.
///
/// A pose is projected by weighted least squares, s = argmin sum_j w_j (q0 + S s - q)_j^2, and
/// each s clamped to its range (which is not the optimum under bounds where columns overlap;
/// the residual tells).
class SynergyMap final : public MotorMap {
 public:
  /// Errors: InvalidInput if shapes differ, a number is not finite, a weight is negative, a
  /// range is empty, or weighted columns of S depend on each other.
  SynergyMap(Eigen::MatrixXd S,
             Eigen::VectorXd offset_rad,
             const Eigen::VectorXd& weights,
             std::vector<Range> motors);

  /// One motor a joint, with the joint's range.
  static SynergyMap direct(const std::vector<Range>& joints);

  [[nodiscard]] std::size_t jointCount() const override {
    return static_cast<std::size_t>(synergies_.rows());
  }

  [[nodiscard]] std::size_t motorCount() const override {
    return static_cast<std::size_t>(synergies_.cols());
  }

  void command(std::span<const double> joint_rad,
               std::span<double> motor_rad,
               std::span<double> residual_rad) override;
  void measure(std::span<const double> motor_rad, std::span<double> joint_rad) override;
  [[nodiscard]] std::vector<Range> motorRanges(std::span<const Range> joints) const override;
  [[nodiscard]] std::vector<double> motorSpeeds(
      std::span<const Range> joints, std::span<const double> joint_speeds) const override;

 private:
  Eigen::MatrixXd synergies_, inverse_;
  Eigen::VectorXd offset_;
  std::vector<Range> motors_;
  Eigen::VectorXd q_, s_;
};

/// A joint that follows another: q = ratio * q(leader) + offset.
struct MimicJoint {
  std::size_t joint = 0;
  std::size_t leader = 0;
  double ratio = 1;
  double offset = 0;
};

/// Motors for the joints that follow nobody, in their order; the leader alone decides.
/// `travel`: what each joint moves by for a radian of its motor; empty: 1.
/// Errors: InvalidInput for a joint that follows twice, itself, a follower, or nobody, and for
/// a travel that is not positive.
SynergyMap mimicMap(const std::vector<Range>& joints,
                    const std::vector<MimicJoint>& followers,
                    const std::vector<double>& travel = {});

}  // namespace handgraft::tendon
