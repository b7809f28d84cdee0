#include "core/optimize/starts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "core/optimize/align_root.h"

namespace handgraft::optimize {

namespace {

/// The positive root of x^(d+1) = x + 1, whose powers spread d coordinates most evenly.
double generalizedGoldenRatio(int dimension) {
  double x = 2.0;
  for (int i = 0; i < 64; ++i) {
    const double next = std::pow(1.0 + x, 1.0 / (dimension + 1.0));
    if (next == x) break;
    x = next;
  }
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

bool isLocked(const PoseProblem& problem, int joint) {
  return !problem.locked.empty() && problem.locked[6 + static_cast<std::size_t>(joint)];
}

/// Fractions in [0, 1) of the joints' ranges: entry `count` of a low-discrepancy sequence.
class JointSequence {
 public:
  JointSequence(int joints, unsigned seed)
      : ratio_(generalizedGoldenRatio(joints)), seed_(seed) {}

  /// Of each joint in turn.
  double next(int joint, int count) {
    stride_ /= ratio_;
    const std::uint64_t key =
        (static_cast<std::uint64_t>(seed_) << 32) + static_cast<unsigned>(joint);
    const double unit = hashToUnit(key) + count * stride_;
    return unit - std::floor(unit);
  }

 private:
  double ratio_;
  unsigned seed_;
  double stride_ = 1.0;
};

// Of a joint's range: how far from the start "near" reaches, and how uneven a curl is.
constexpr double kNear = 0.3;
constexpr double kUneven = 0.2;

/// The joints of start `index` >= 4, by its kind.
void spreadJoints(const PoseProblem& problem, int index, unsigned seed, Eigen::VectorXd& q) {
  const int joints = problem.model->dofCount();
  JointSequence sequence(joints, seed);
  // The same curl for all joints, from the start towards their upper limits.
  const double curl = hashToUnit((static_cast<std::uint64_t>(seed) << 32) + 0x80000000U +
                                 static_cast<unsigned>(index));
  for (int j = 0; j < joints; ++j) {
    const double fraction = sequence.next(j, index - 3);
    if (isLocked(problem, j)) continue;
    const double spread = jointAt(problem, j, fraction);
    switch (startKind(index)) {
      case StartKind::kNear:
        q[j] += kNear * (spread - q[j]);
        break;
      case StartKind::kCurled: {
        const double range = jointAt(problem, j, 1.0) - jointAt(problem, j, 0.0);
        q[j] += curl * (jointAt(problem, j, 1.0) - q[j]) + kUneven * (fraction - 0.5) * range;
        break;
      }
      default:
        q[j] = spread;
    }
    q[j] = std::clamp(q[j], std::min(problem.lower[j], problem.upper[j]), problem.upper[j]);
  }
}

// Measured (DECISIONS): turned starts find what the others miss, near ones find all the same.
constexpr std::array kCycle = {StartKind::kTurned, StartKind::kCurled, StartKind::kTurned,
                               StartKind::kSpread, StartKind::kNear};
constexpr int kFirstSpread = 4;

/// How many turned starts come before start `index`.
int turnedBefore(int index) {
  int count = 0;
  for (int i = kFirstSpread; i < index; ++i)
    count += startKind(i) == StartKind::kTurned ? 1 : 0;
  return count;
}

/// Half turns about x, y, z, then quarter turns to either side.
Eigen::Matrix3d turnOf(int count) {
  const Eigen::Vector3d axis = Eigen::Vector3d::Unit(count % 3);
  const int round = count / 3 % 3;
  const double angle = round == 0 ? std::numbers::pi : 0.5 * std::numbers::pi;
  return rotationFromVector((round == 2 ? -angle : angle) * axis);
}

}  // namespace

StartKind startKind(int index) {
  switch (index) {
    case 0:
      return StartKind::kOwn;
    case 1:
    case 2:
    case 3:
      return StartKind::kAligned;
    default:
      break;
  }
  return kCycle[static_cast<std::size_t>(index - kFirstSpread) % kCycle.size()];
}

hand::HandPose startPose(const PoseProblem& problem,
                         const MomentTree& tree,
                         int index,
                         unsigned seed) {
  hand::HandPose pose = problem.start;
  if (index == 0) return pose;
  if (index == 2 || index == 3) {
    const Eigen::VectorXd wanted = index == 2 ? problem.prior.q : problem.model->restPose();
    for (Eigen::Index j = 0; j < pose.q.size(); ++j) {
      if (!isLocked(problem, static_cast<int>(j))) pose.q[j] = wanted[j];
    }
  } else if (index >= kFirstSpread) {
    spreadJoints(problem, index, seed, pose.q);
  }
  pose.X_WH = alignRoot(problem, tree, pose.q);
  if (startKind(index) == StartKind::kTurned) {
    pose.X_WH = turnRoot(problem, tree, pose.X_WH, turnOf(turnedBefore(index)));
  }
  return pose;
}

hand::HandPose startAbout(const hand::HandPose& found,
                          const PoseProblem& problem,
                          const MomentTree& tree,
                          int index,
                          unsigned seed) {
  constexpr double kMoved = 1.0 / 3.0;  // of the joints
  constexpr double kWay = 0.8;          // of the way to a place of the joint's range
  hand::HandPose pose = found;
  const auto joints = static_cast<std::uint64_t>(pose.q.size());
  for (Eigen::Index j = 0; j < pose.q.size(); ++j) {
    const int joint = static_cast<int>(j);
    const std::uint64_t draw =
        2 * (static_cast<std::uint64_t>(index) * joints + static_cast<std::uint64_t>(j));
    const std::uint64_t key = (static_cast<std::uint64_t>(seed) << 32) + 0x40000000U + draw;
    if (isLocked(problem, joint) || hashToUnit(key) >= kMoved) continue;
    pose.q[j] += kWay * (jointAt(problem, joint, hashToUnit(key + 1)) - pose.q[j]);
    pose.q[j] =
        std::clamp(pose.q[j], std::min(problem.lower[j], problem.upper[j]), problem.upper[j]);
  }
  pose.X_WH = alignRoot(problem, tree, pose.q);
  return pose;
}

}  // namespace handgraft::optimize
