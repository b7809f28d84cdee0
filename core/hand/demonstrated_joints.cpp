#include "core/hand/demonstrated_joints.h"

#include <array>
#include <cmath>

#include "core/base/angle.h"
#include "core/base/error.h"
#include "core/hand/mano_joints.h"

namespace handgraft::hand {

namespace {

constexpr int kFirstOfMiddle = 9;
constexpr int kDigits = 5;

int knuckleOf(int digit) {
  return 1 + 4 * digit;
}

/// What is of much the same proportions in all hands, however they are bent: of each digit how
/// far its knuckle is from the wrist and how long its segments are, then the gaps between
/// fingers' knuckles.
using Lengths = Eigen::Matrix<double, 4 * kDigits + 3, 1>;

Lengths lengthsOf(const JointPlaces& joints) {
  Lengths lengths;
  int at = 0;
  for (int digit = 0; digit < kDigits; ++digit) {
    const int knuckle = knuckleOf(digit);
    lengths[at++] = (joints.col(knuckle) - joints.col(0)).norm();
    for (int joint = knuckle; joint < knuckle + 3; ++joint)
      lengths[at++] = (joints.col(joint + 1) - joints.col(joint)).norm();
  }
  for (int digit = 1; digit + 1 < kDigits; ++digit)
    lengths[at++] = (joints.col(knuckleOf(digit + 1)) - joints.col(knuckleOf(digit))).norm();
  return lengths;
}

/// How unlike a hand of any size: the part of its lengths that is no multiple of the mean
/// hand's; 0 to 1.
double unlikeness(const JointPlaces& joints) {
  static const Lengths mean =
      lengthsOf(manoJointPlaces(Eigen::Matrix<double, kManoPoseSize, 1>::Zero(),
                                Eigen::Vector3d::Zero(), HandSide::kRight));
  const Lengths lengths = lengthsOf(joints);
  const double size = lengths.dot(mean) / mean.squaredNorm();
  return (lengths - size * mean).norm() / lengths.norm();
}

/// Where each of our joints stands in the order of others.
struct OtherOrder {
  const char* what;
  std::array<int, 21> column_of;
};

constexpr std::array<OtherOrder, 8> kOtherOrders{{
    {"each digit's tip first",
     {0, 4, 3, 2, 1, 8, 7, 6, 5, 12, 11, 10, 9, 16, 15, 14, 13, 20, 19, 18, 17}},
    {"the thumb last",
     {0, 17, 18, 19, 20, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16}},
    {"the thumb last, each digit's tip first",
     {0, 20, 19, 18, 17, 4, 3, 2, 1, 8, 7, 6, 5, 12, 11, 10, 9, 16, 15, 14, 13}},
    {"the little finger first, the thumb last",
     {0, 17, 18, 19, 20, 13, 14, 15, 16, 9, 10, 11, 12, 5, 6, 7, 8, 1, 2, 3, 4}},
    {"MANO's order (index, middle, little, ring, thumb, then the tips)",
     {0, 13, 14, 15, 16, 1, 2, 3, 17, 4, 5, 6, 18, 10, 11, 12, 19, 7, 8, 9, 20}},
    {"MANO's order (index, middle, little, ring, thumb, then the tips, the thumb's last)",
     {0, 13, 14, 15, 20, 1, 2, 3, 16, 4, 5, 6, 17, 10, 11, 12, 18, 7, 8, 9, 19}},
    {"the wrist last",
     {20, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19}},
    {"all knuckles first, all tips last",
     {0, 1, 6, 11, 16, 2, 7, 12, 17, 3, 8, 13, 18, 4, 9, 14, 19, 5, 10, 15, 20}},
}};

void requireHandSized(const JointPlaces& joints) {
  constexpr double kShortest = 0.05;  // m
  constexpr double kLongest = 0.5;    // m
  double length = (joints.col(kFirstOfMiddle) - joints.col(0)).norm();
  for (int joint = kFirstOfMiddle; joint < kFirstOfMiddle + 3; ++joint)
    length += (joints.col(joint + 1) - joints.col(joint)).norm();
  const auto is_hands = [](double length_m) {
    return length_m >= kShortest && length_m <= kLongest;
  };
  if (is_hands(length)) return;
  rejectInput(
      "from the wrist along the middle finger to its tip {:.3g} m; a hand has {} to "
      "{}{}",
      length, kShortest, kLongest,
      is_hands(1e-3 * length)   ? ": millimetres?"
      : is_hands(1e-2 * length) ? ": centimetres?"
                                : "");
}

void requireOurOrder(const JointPlaces& joints) {
  // Hands of recordings come to 0.11, a child's with noise to 0.25, where another order seems
  // at most 1.3 times as likely; joints in another order to 0.23 and more, and 2.3 times.
  constexpr double kStillAHand = 0.2;
  constexpr double kMuchLikelier = 1.5;
  const double ours = unlikeness(joints);
  if (ours <= kStillAHand) return;
  const OtherOrder* best = nullptr;
  double least = ours / kMuchLikelier;
  for (const OtherOrder& order : kOtherOrders) {
    JointPlaces ordered;
    for (int joint = 0; joint < ordered.cols(); ++joint)
      ordered.col(joint) = joints.col(order.column_of[static_cast<std::size_t>(joint)]);
    const double its = unlikeness(ordered);
    if (its >= least) continue;
    least = its;
    best = &order;
  }
  if (best != nullptr)
    rejectInput(
        "the joints seem to stand in another order, {}; it must be the wrist, then thumb, "
        "index, middle, ring, little: three from the knuckle, and the tip",
        best->what);
}

void requireShortSegments(const JointPlaces& joints) {
  constexpr double kLongest = 0.08;  // m
  constexpr std::array<const char*, kDigits> kNames{"thumb", "index finger", "middle finger",
                                                    "ring finger", "little finger"};
  for (int digit = 0; digit < kDigits; ++digit) {
    for (int joint = knuckleOf(digit); joint < knuckleOf(digit) + 3; ++joint) {
      const double length = (joints.col(joint + 1) - joints.col(joint)).norm();
      if (length <= kLongest) continue;
      rejectInput("joints {} and {}, of the {}, lie {:.0f} mm apart; permitted are {:.0f}",
                  joint, joint + 1, kNames[static_cast<std::size_t>(digit)], 1e3 * length,
                  1e3 * kLongest);
    }
  }
}

}  // namespace

double fingerBend(const JointPlaces& joints, HandSide side) {
  const Eigen::Vector3d thumbward =
      (side == HandSide::kRight ? 1.0 : -1.0) * (joints.col(5) - joints.col(17));
  double sum = 0.0;
  for (int digit = 1; digit < kDigits; ++digit) {
    const int knuckle = knuckleOf(digit);
    // Beyond the knuckle, where fingers do not bend backwards; all of it, for the noise's sake.
    const Eigen::Vector3d bone = (joints.col(knuckle + 1) - joints.col(knuckle)).normalized();
    const Eigen::Vector3d rest = joints.col(knuckle + 3) - joints.col(knuckle + 1);
    const Eigen::Vector3d palmar = thumbward.cross(bone).normalized();
    sum += std::atan2(rest.dot(palmar), rest.dot(bone));
  }
  return sum / (kDigits - 1);
}

void requireHand(const JointPlaces& joints, HandSide side) {
  // Recorded hands are bent by 2 deg at least, with noise of 3 mm by -11.
  constexpr double kBackwards = -25.0;  // deg
  if (!joints.allFinite()) rejectInput("a joint's place is not finite");
  requireHandSized(joints);
  requireOurOrder(joints);
  requireShortSegments(joints);
  const double bend_deg = inDegrees(fingerBend(joints, side));
  if (bend_deg >= kBackwards) return;
  rejectInput("the fingers bend backwards by {:.0f} deg: is it a {} hand, or mirrored?",
              -bend_deg, side == HandSide::kRight ? "left" : "right");
}

}  // namespace handgraft::hand
