#include "hardware/tendon/tendon_map.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"

namespace handgraft::tendon {

namespace {

TendonHand validated(TendonHand hand) {
  std::string all;
  for (const std::string& problem : problemsOf(hand))
    all += (all.empty() ? "" : "; ") + problem;
  if (!all.empty()) throw InvalidInput(all);
  return hand;
}

}  // namespace

TendonMap::TendonMap(TendonHand hand) : hand_(validated(std::move(hand))) {
  const auto n = static_cast<Eigen::Index>(jointCount());
  const auto m = static_cast<Eigen::Index>(motorCount());
  e_.setZero(m);
  q_.setZero(n);
  for (const Tendon& tendon : hand_.tendons) {
    pretensions_.push_back(tendon.pretension);
    largest_.push_back(tendon.largest_tension);
  }
  zeros_.assign(motorCount(), 0.0);
  tensions_ = zeros_;
  if (hand_.isElastic()) {
    elastic_.emplace(hand_);
  } else {
    const Eigen::MatrixXd R = arms(std::vector<double>(jointCount()));
    inverse_ = R.completeOrthogonalDecomposition().pseudoInverse();
  }
}

double TendonMap::excursion(std::size_t tendon, std::span<const double> joint_rad) const {
  double e = 0;
  for (const Crossing& crossing : hand_.tendons[tendon].crossings)
    e += crossing.extension.at(joint_rad[crossing.joint]).e;
  return e;
}

Eigen::MatrixXd TendonMap::arms(std::span<const double> joint_rad) const {
  HANDGRAFT_REQUIRE(joint_rad.size() == jointCount());
  Eigen::MatrixXd R = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(motorCount()),
                                            static_cast<Eigen::Index>(jointCount()));
  for (std::size_t i = 0; i < motorCount(); ++i) {
    for (const Crossing& crossing : hand_.tendons[i].crossings)
      R(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(crossing.joint)) =
          crossing.extension.at(joint_rad[crossing.joint]).slope;
  }
  return R;
}

void TendonMap::command(std::span<const double> joint_rad,
                        std::span<double> motor_rad,
                        std::span<double> residual_rad) {
  HANDGRAFT_REQUIRE(joint_rad.size() == jointCount() && residual_rad.size() == jointCount() &&
                    motor_rad.size() == motorCount());
  for (std::size_t i = 0; i < motorCount(); ++i)
    e_[static_cast<Eigen::Index>(i)] = excursion(i, joint_rad);
  if (!elastic_) {
    for (std::size_t i = 0; i < motorCount(); ++i)
      motor_rad[i] = hand_.tendons[i].spool.angleAt(e_[static_cast<Eigen::Index>(i)]);
    std::fill(residual_rad.begin(), residual_rad.end(), 0.0);
    return;
  }
  elastic_->solve({e_.data(), motorCount()}, pretensions_, largest_,
                  ElasticPosture::Stretch::kNone);
  std::copy(elastic_->tensions().begin(), elastic_->tensions().end(), tensions_.begin());
  for (std::size_t i = 0; i < motorCount(); ++i) {
    const Tendon& tendon = hand_.tendons[i];
    motor_rad[i] =
        tendon.spool.angleAt(elastic_->excursionOf(i) + tensions_[i] / tendon.stiffness);
  }
  for (std::size_t j = 0; j < jointCount(); ++j)
    residual_rad[j] = joint_rad[j] - elastic_->posture()[j];
}

void TendonMap::measure(std::span<const double> motor_rad, std::span<double> joint_rad) {
  HANDGRAFT_REQUIRE(joint_rad.size() == jointCount() && motor_rad.size() == motorCount());
  for (std::size_t i = 0; i < motorCount(); ++i)
    e_[static_cast<Eigen::Index>(i)] = hand_.tendons[i].spool.excursionAt(motor_rad[i]);
  if (elastic_) {
    elastic_->solve({e_.data(), motorCount()}, zeros_, largest_,
                    ElasticPosture::Stretch::kTendons);
    std::copy(elastic_->posture().begin(), elastic_->posture().end(), joint_rad.begin());
    return;
  }
  q_.noalias() = inverse_ * e_;
  std::copy(q_.begin(), q_.end(), joint_rad.begin());
}

std::vector<Range> TendonMap::motorRanges(std::span<const Range> joints) const {
  HANDGRAFT_REQUIRE(joints.size() == jointCount());
  std::vector<Range> ranges;
  for (const Tendon& tendon : hand_.tendons) {
    Range e;
    for (const Crossing& crossing : tendon.crossings) {
      const Range one = crossing.extension.excursions(joints[crossing.joint]);
      e = {e.lower + one.lower, e.upper + one.upper};
    }
    // Taking up slack to the pretension may wind in more, and stretch always does.
    if (hand_.isElastic()) e.upper += tendon.largest_tension / tendon.stiffness;
    ranges.push_back({tendon.spool.angleAt(e.lower), tendon.spool.angleAt(e.upper)});
  }
  return ranges;
}

std::vector<double> TendonMap::motorSpeeds(std::span<const Range> joints,
                                           std::span<const double> joint_speeds) const {
  HANDGRAFT_REQUIRE(joints.size() == jointCount() && joint_speeds.size() == jointCount());
  const std::vector<Range> ranges = motorRanges(joints);
  std::vector<double> speeds;
  for (std::size_t i = 0; i < motorCount(); ++i) {
    const Tendon& tendon = hand_.tendons[i];
    double speed = 0;
    for (const Crossing& crossing : tendon.crossings) {
      const Range slopes = crossing.extension.slopes(joints[crossing.joint]);
      speed += std::max(std::abs(slopes.lower), std::abs(slopes.upper)) *
               joint_speeds[crossing.joint];
    }
    const double least = tendon.spool.radiusAt(tendon.spool.excursionAt(ranges[i].lower));
    speeds.push_back(speed / least);
  }
  return speeds;
}

}  // namespace handgraft::tendon
