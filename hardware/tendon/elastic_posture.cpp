#include "hardware/tendon/elastic_posture.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"

namespace handgraft::tendon {

namespace {

constexpr int kMostSweeps = 200;
constexpr int kMostSteps = 100;  // of one safeguarded Newton; bisection alone needs 60
// Rounding of excursions of a few centimetres is 1e-17 m.
constexpr double kExcursionNoise = 1e-16;  // m
constexpr double kSettled = 1e-15;         // m, change of any excursion in a sweep
constexpr double kAngleNoise = 1e-15;      // rad

struct Slope {
  double value;
  double slope;
};

/// Where the growing function `f` is zero in [lower, upper], or the end nearer to it.
template <class Function>
double zeroOfGrowing(double lower, double upper, double start, double noise, Function f) {
  double x = std::clamp(start, lower, upper);
  for (int i = 0; i < kMostSteps; ++i) {
    const Slope at = f(x);
    if (std::abs(at.value) <= noise) return x;
    (at.value > 0 ? upper : lower) = x;
    if (!(upper > lower)) return x;
    double next = at.slope > 0 ? x - at.value / at.slope : x;
    // A step out of the bracket, or none: to its end once, then by halves.
    if (!(next > lower && next < upper)) {
      const double end = at.value > 0 ? lower : upper;
      const Slope there = f(end);
      if (at.value > 0 ? there.value >= 0 : there.value <= 0) return end;
      next = lower + (upper - lower) / 2;
      if (!(next > lower && next < upper)) return x;
    }
    x = next;
  }
  return x;
}

}  // namespace

ElasticPosture::ElasticPosture(const TendonHand& hand)
    : joints_(hand.joints),
      pulls_(hand.joints.size()),
      q_(hand.joints.size()),
      give_(hand.joints.size()),
      f_(hand.tendons.size()) {
  HANDGRAFT_REQUIRE(hand.isElastic());
  for (std::size_t i = 0; i < hand.tendons.size(); ++i) {
    const Tendon& tendon = hand.tendons[i];
    crossings_.push_back(tendon.crossings);
    compliance_.push_back(1 / tendon.stiffness);
    for (const Crossing& crossing : tendon.crossings)
      pulls_[crossing.joint].push_back({i, crossing.extension});
  }
  for (std::size_t j = 0; j < joints_.size(); ++j)
    q_[j] = std::clamp(joints_[j].rest, joints_[j].range.lower, joints_[j].range.upper);
}

// Balances one joint's spring against the tensions that cross it.
void ElasticPosture::relax(std::size_t j) {
  const TendonJoint& joint = joints_[j];
  const auto torque = [&](double q) -> Slope {
    Slope sum{joint.stiffness * (q - joint.rest), joint.stiffness};
    for (const Pull& pull : pulls_[j]) {
      const Extension::Value at = pull.extension.at(q);
      sum.value -= f_[pull.tendon] * at.slope;
      sum.slope -= f_[pull.tendon] * at.curvature;
    }
    return sum;
  };
  const double noise = joint.stiffness * kAngleNoise;
  q_[j] = zeroOfGrowing(joint.range.lower, joint.range.upper, q_[j], noise, torque);
  const Slope at = torque(q_[j]);
  const bool is_stopped = (q_[j] == joint.range.lower && at.value >= 0) ||
                          (q_[j] == joint.range.upper && at.value <= 0);
  give_[j] = is_stopped || !(at.slope > 0) ? 0 : 1 / at.slope;
}

double ElasticPosture::excursionOf(std::size_t i) const {
  double e = 0;
  for (const Crossing& crossing : crossings_[i])
    e += crossing.extension.at(q_[crossing.joint]).e;
  return e;
}

void ElasticPosture::pull(
    std::size_t i, double e_m, double lowest, double highest, double compliance) {
  const auto missing = [&](double f) -> Slope {
    f_[i] = f;
    Slope sum{compliance * f - e_m, compliance};
    for (const Crossing& crossing : crossings_[i]) {
      relax(crossing.joint);
      const Extension::Value at = crossing.extension.at(q_[crossing.joint]);
      sum.value += at.e;
      sum.slope += at.slope * at.slope * give_[crossing.joint];
    }
    return sum;
  };
  const double f = zeroOfGrowing(lowest, highest, f_[i], kExcursionNoise, missing);
  missing(f);
}

bool ElasticPosture::solve(std::span<const double> e_m,
                           std::span<const double> lowest_N,
                           std::span<const double> highest_N,
                           Stretch stretch) {
  HANDGRAFT_REQUIRE(e_m.size() == f_.size() && lowest_N.size() == f_.size() &&
                    highest_N.size() == f_.size());
  // Always from the same start: equal input, equal answer.
  for (std::size_t i = 0; i < f_.size(); ++i)
    f_[i] = lowest_N[i];
  for (std::size_t j = 0; j < q_.size(); ++j)
    relax(j);
  for (int sweep = 0; sweep < kMostSweeps; ++sweep) {
    double change = 0;
    for (std::size_t i = 0; i < f_.size(); ++i) {
      const double before = excursionOf(i);
      pull(i, e_m[i], lowest_N[i], highest_N[i],
           stretch == Stretch::kTendons ? compliance_[i] : 0.0);
      change = std::max(change, std::abs(excursionOf(i) - before));
    }
    if (change <= kSettled) return true;
  }
  return false;
}

}  // namespace handgraft::tendon
