#include "core/hand/demonstrated_joints.h"

#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "core/base/angle.h"
#include "core/base/error.h"
#include "core/base/pose.h"

namespace handgraft::hand {

namespace {

struct ManoDigit {
  int column = 0;                         // of its first joint among the places
  int entry = 0;                          // of its first joint in the pose
  std::array<Eigen::Vector3d, 3> offset;  // of each joint from the one before, right hand, m
  double tip_m = 0.0;                     // length of the last bone
};

// Of the mean right hand, from MANO's origin.
const Eigen::Vector3d rest_wrist(0.0956699, 0.0063834, 0.0061863);

const std::array<ManoDigit, 5> mano_digits{
    {{1,
      39,
      {Eigen::Vector3d(-0.0240897, -0.0155223, 0.0258128),
       {-0.0196332, 0.0008913, 0.0236996},
       {-0.0222177, -0.0054330, 0.0145241}},
      0.030},
     {5,
      3,
      {Eigen::Vector3d(-0.0880973, -0.0052004, 0.0206860),
       {-0.0326789, 0.0040094, 0.0022171},
       {-0.0221559, -0.0012984, -0.0001141}},
      0.024},
     {9,
      12,
      {Eigen::Vector3d(-0.0946605, -0.0014790, -0.0033575),
       {-0.0311827, 0.0018613, -0.0055945},
       {-0.0229046, -0.0012521, -0.0039445}},
      0.025},
     {13,
      30,
      {Eigen::Vector3d(-0.0817356, -0.0039574, -0.0266732),
       {-0.0283143, 0.0020670, -0.0050985},
       {-0.0235205, -0.0016881, -0.0076338}},
      0.025},
     {17,
      21,
      {Eigen::Vector3d(-0.0687870, -0.0099403, -0.0432093),
       {-0.0170144, 0.0000618, -0.0124988},
       {-0.0158669, -0.0006912, -0.0103319}},
      0.020}}};

/// MANO's left model is its right one mirrored.
Eigen::Vector3d mirrorOf(HandSide side) {
  return {side == HandSide::kRight ? 1.0 : -1.0, 1.0, 1.0};
}

void requireRadians(const Eigen::Matrix<double, kManoPoseSize, 1>& pose_rad) {
  // Not the root's, which those who fit poses may turn further.
  for (int entry = 3; entry < kManoPoseSize; entry += 3) {
    const double turn = pose_rad.segment<3>(entry).norm();
    if (turn <= 2.0 * std::numbers::pi) continue;
    rejectInput(
        "MANO's pose: joint {} turns by {:.4g} rad; permitted are at most 2 pi: degrees?",
        entry / 3, turn);
  }
}

// === Whether joints are a hand's

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

Eigen::Vector3d manoRestWrist(HandSide side) {
  return mirrorOf(side).cwiseProduct(rest_wrist);
}

JointPlaces manoJointPlaces(const Eigen::Matrix<double, kManoPoseSize, 1>& pose_rad,
                            const Eigen::Vector3d& translation_W,
                            HandSide side) {
  requireRadians(pose_rad);
  const Eigen::Vector3d mirror = mirrorOf(side);
  const auto turned = [&](int entry) -> Eigen::Matrix3d {
    return rotationFromVector(pose_rad.segment<3>(entry));
  };
  JointPlaces places;
  places.col(0) = translation_W + manoRestWrist(side);
  for (const ManoDigit& digit : mano_digits) {
    Eigen::Matrix3d R_W = turned(0);
    Eigen::Vector3d p_W = places.col(0);
    for (int joint = 0; joint < 3; ++joint) {
      p_W += R_W * mirror.cwiseProduct(digit.offset[static_cast<std::size_t>(joint)]);
      places.col(digit.column + joint) = p_W;
      R_W = R_W * turned(digit.entry + 3 * joint);
    }
    const Eigen::Vector3d bone = mirror.cwiseProduct(digit.offset[2]).normalized();
    places.col(digit.column + 3) = p_W + digit.tip_m * (R_W * bone);
  }
  return places;
}

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
