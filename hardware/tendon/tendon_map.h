#pragma once

#include <optional>

#include <Eigen/Dense>

#include "hardware/tendon/elastic_posture.h"
#include "hardware/tendon/motor_map.h"
#include "hardware/tendon/tendon_hand.h"

namespace handgraft::tendon {

/// Joints <-> tendon excursions <-> drum angles, one motor a tendon.
///
/// Elastic hand: a pose is projected to the excursions that it needs; with tensions held
/// between pretension and the largest, the posture of least energy there is what the hand
/// takes, and the difference is the residual. What tendons stretch is wound in on top. A slack
/// tendon is taken up to its pretension. Measuring goes from drums to the posture, slack
/// tendons included.
///
/// Rigid hand (constant arms, no springs): e = R q, motors in the range of R, so antagonists
/// are neither slackened nor overloaded (Abdallah et al. 2011); measuring takes the least
/// squares R^+ e.
///
/// Not modelled: friction along channels, hence hysteresis; backlash; outside loads.
class TendonMap final : public MotorMap {
 public:
  /// Errors: InvalidInput with all of `problemsOf(hand)`.
  explicit TendonMap(TendonHand hand);

  [[nodiscard]] std::size_t jointCount() const override { return hand_.joints.size(); }

  [[nodiscard]] std::size_t motorCount() const override { return hand_.tendons.size(); }

  void command(std::span<const double> joint_rad,
               std::span<double> motor_rad,
               std::span<double> residual_rad) override;
  void measure(std::span<const double> motor_rad, std::span<double> joint_rad) override;
  [[nodiscard]] std::vector<Range> motorRanges(std::span<const Range> joints) const override;
  /// Elastic hands: the excursions' speed; what stretch adds while tensions change is left out.
  [[nodiscard]] std::vector<double> motorSpeeds(
      std::span<const Range> joints, std::span<const double> joint_speeds) const override;

  /// de_i/dq_j at `joint_rad`, tendons x joints, m/rad: R, the transpose of the coupling
  /// matrix.
  [[nodiscard]] Eigen::MatrixXd arms(std::span<const double> joint_rad) const;

  /// Of the newest `command`, N, one per tendon; zeros for a rigid hand.
  [[nodiscard]] const std::vector<double>& tensions() const { return tensions_; }

 private:
  [[nodiscard]] double excursion(std::size_t tendon, std::span<const double> joint_rad) const;

  TendonHand hand_;
  std::optional<ElasticPosture> elastic_;
  Eigen::MatrixXd inverse_;  // R^+ of a rigid hand
  Eigen::VectorXd e_;
  Eigen::VectorXd q_;
  std::vector<double> pretensions_, largest_, zeros_;
  std::vector<double> tensions_;
};

}  // namespace handgraft::tendon
