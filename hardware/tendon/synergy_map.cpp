#include "hardware/tendon/synergy_map.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/base/error.h"

namespace handgraft::tendon {

SynergyMap::SynergyMap(Eigen::MatrixXd S,
                       Eigen::VectorXd offset_rad,
                       const Eigen::VectorXd& weights,
                       std::vector<Range> motors)
    : synergies_(std::move(S)), offset_(std::move(offset_rad)), motors_(std::move(motors)) {
  const Eigen::Index n = synergies_.rows(), m = synergies_.cols();
  if (n == 0 || m == 0 || offset_.size() != n || weights.size() != n ||
      motors_.size() != static_cast<std::size_t>(m)) {
    rejectInput("a synergy of {} joints and {} motors has {} offsets, {} weights, {} ranges", n,
                m, offset_.size(), weights.size(), motors_.size());
  }
  if (!synergies_.allFinite() || !offset_.allFinite() || !weights.allFinite())
    rejectInput("synergies, offsets and weights must be finite");
  if (!(weights.minCoeff() >= 0))
    rejectInput("synergy weight {} is not in [0, inf)", weights.minCoeff());
  for (const Range& range : motors_) {
    if (!(range.lower <= range.upper))
      rejectInput("motor range [{}, {}] rad is empty", range.lower, range.upper);
  }
  const Eigen::VectorXd root = weights.cwiseSqrt();
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> decomposed(root.asDiagonal() * synergies_);
  decomposed.setThreshold(1e-9);
  if (decomposed.rank() < m) {
    rejectInput("{} synergies move {} joints in {} ways only", m, n, decomposed.rank());
  }
  inverse_ = decomposed.solve(Eigen::MatrixXd(root.asDiagonal()));
  q_.setZero(n);
  s_.setZero(m);
}

SynergyMap SynergyMap::direct(const std::vector<Range>& joints) {
  return mimicMap(joints, {});
}

void SynergyMap::command(std::span<const double> joint_rad,
                         std::span<double> motor_rad,
                         std::span<double> residual_rad) {
  HANDGRAFT_REQUIRE(joint_rad.size() == jointCount() && residual_rad.size() == jointCount() &&
                    motor_rad.size() == motorCount());
  const Eigen::Map<const Eigen::VectorXd> wanted(joint_rad.data(), synergies_.rows());
  q_ = wanted - offset_;
  s_.noalias() = inverse_ * q_;
  for (std::size_t i = 0; i < motorCount(); ++i) {
    double& s = s_[static_cast<Eigen::Index>(i)];
    s = std::clamp(s, motors_[i].lower, motors_[i].upper);
    motor_rad[i] = s;
  }
  q_.noalias() -= synergies_ * s_;
  std::copy(q_.begin(), q_.end(), residual_rad.begin());
}

void SynergyMap::measure(std::span<const double> motor_rad, std::span<double> joint_rad) {
  HANDGRAFT_REQUIRE(joint_rad.size() == jointCount() && motor_rad.size() == motorCount());
  const Eigen::Map<const Eigen::VectorXd> s(motor_rad.data(), synergies_.cols());
  q_ = offset_;
  q_.noalias() += synergies_ * s;
  std::copy(q_.begin(), q_.end(), joint_rad.begin());
}

std::vector<Range> SynergyMap::motorRanges(std::span<const Range> joints) const {
  HANDGRAFT_REQUIRE(joints.size() == jointCount());
  std::vector<Range> ranges;
  for (Eigen::Index i = 0; i < synergies_.cols(); ++i) {
    Range sum;
    for (Eigen::Index j = 0; j < synergies_.rows(); ++j) {
      if (inverse_(i, j) == 0) continue;  // and its range may be infinite
      const Range& range = joints[static_cast<std::size_t>(j)];
      const double a = inverse_(i, j) * (range.lower - offset_[j]);
      const double b = inverse_(i, j) * (range.upper - offset_[j]);
      sum = {sum.lower + std::min(a, b), sum.upper + std::max(a, b)};
    }
    const Range& motor = motors_[static_cast<std::size_t>(i)];
    ranges.push_back({std::clamp(sum.lower, motor.lower, motor.upper),
                      std::clamp(sum.upper, motor.lower, motor.upper)});
  }
  return ranges;
}

std::vector<double> SynergyMap::motorSpeeds(std::span<const Range> joints,
                                            std::span<const double> joint_speeds) const {
  HANDGRAFT_REQUIRE(joints.size() == jointCount() && joint_speeds.size() == jointCount());
  std::vector<double> speeds(motorCount());
  for (Eigen::Index i = 0; i < synergies_.cols(); ++i) {
    for (Eigen::Index j = 0; j < synergies_.rows(); ++j)
      speeds[static_cast<std::size_t>(i)] +=
          std::abs(inverse_(i, j)) * joint_speeds[static_cast<std::size_t>(j)];
  }
  return speeds;
}

SynergyMap mimicMap(const std::vector<Range>& joints,
                    const std::vector<MimicJoint>& followers,
                    const std::vector<double>& travel) {
  if (!travel.empty() && travel.size() != joints.size())
    rejectInput("{} travels for {} joints", travel.size(), joints.size());
  const auto travel_of = [&travel](std::size_t j) {
    return travel.empty() ? 1.0 : travel[j];
  };
  std::vector<std::optional<MimicJoint>> follows(joints.size());
  for (const MimicJoint& follower : followers) {
    if (follower.joint >= joints.size() || follower.leader >= joints.size() ||
        follower.joint == follower.leader || follows[follower.joint])
      rejectInput("joint {} cannot follow joint {}", follower.joint, follower.leader);
    follows[follower.joint] = follower;
  }
  std::vector<Eigen::Index> column(joints.size(), -1);
  std::vector<Range> motors;
  for (std::size_t j = 0; j < joints.size(); ++j) {
    if (follows[j]) continue;
    if (!(travel_of(j) > 0))
      rejectInput("joint {}: travel {} is not positive", j, travel_of(j));
    column[j] = static_cast<Eigen::Index>(motors.size());
    motors.push_back({joints[j].lower / travel_of(j), joints[j].upper / travel_of(j)});
  }
  const auto n = static_cast<Eigen::Index>(joints.size());
  Eigen::MatrixXd S = Eigen::MatrixXd::Zero(n, static_cast<Eigen::Index>(motors.size()));
  Eigen::VectorXd offset = Eigen::VectorXd::Zero(n), weights = Eigen::VectorXd::Zero(n);
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const auto row = static_cast<Eigen::Index>(j);
    if (!follows[j]) {
      S(row, column[j]) = travel_of(j);
      weights[row] = 1;
      continue;
    }
    if (column[follows[j]->leader] < 0)
      rejectInput("joint {} follows joint {}, which follows another", j, follows[j]->leader);
    S(row, column[follows[j]->leader]) = follows[j]->ratio * travel_of(follows[j]->leader);
    offset[row] = follows[j]->offset;
  }
  return {std::move(S), std::move(offset), weights, std::move(motors)};
}

}  // namespace handgraft::tendon
