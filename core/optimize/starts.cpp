#include "core/optimize/starts.h"

#include <cmath>
#include <cstdint>
#include <numbers>

#include "core/optimize/solver.h"

namespace handgraft::optimize {

namespace {

/// The positive root of x^(d+1) = x + 1, whose powers spread d coordinates most evenly.
double generalizedGoldenRatio(int dimension) {
  double x = 2.0;
  for (int i = 0; i < 64; ++i)
    x = std::pow(1.0 + x, 1.0 / (dimension + 1.0));
  return x;
}

/// A number in [0, 1) that two equal inputs share and others do not. Source: Steele, Lea &
/// Flood 2014, splitmix64.
double hashToUnit(std::uint64_t value) {
  std::uint64_t z = value + 0x9e3779b97f4a7c15ULL;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  z ^= z >> 31;
  return static_cast<double>(z >> 11) * 0x1.0p-53;
}

/// `fraction` in [0, 1) of joint j's range.
double jointAt(const PoseProblem& problem, int joint, double fraction) {
  const bool prismatic = problem.model->dofJoint(joint).type == hand::JointType::kPrismatic;
  const double reach = prismatic ? 0.05 : 0.5 * std::numbers::pi;
  const double start = problem.start.q[joint];
  double lower = problem.lower[joint];
  double upper = problem.upper[joint];
  if (std::isinf(lower)) lower = std::min(start, upper) - reach;
  if (std::isinf(upper)) upper = std::max(start, lower) + reach;
  return lower + fraction * (upper - lower);
}

}  // namespace

hand::HandPose startPose(const PoseProblem& problem, int index, unsigned seed) {
  hand::HandPose pose = problem.start;
  if (index == 0) return pose;
  const int joints = problem.model->dofCount();
  if (index >= 2) {
    const double ratio = generalizedGoldenRatio(joints);
    double stride = 1.0;
    for (int j = 0; j < joints; ++j) {
      stride /= ratio;
      if (!problem.locked.empty() && problem.locked[static_cast<std::size_t>(6 + j)]) continue;
      const std::uint64_t key =
          (static_cast<std::uint64_t>(seed) << 32) + static_cast<unsigned>(j);
      const double unit = hashToUnit(key) + (index - 1) * stride;
      pose.q[j] = jointAt(problem, j, unit - std::floor(unit));
    }
  }
  pose.X_WH = alignRoot(problem, pose.q);
  return pose;
}

}  // namespace handgraft::optimize
