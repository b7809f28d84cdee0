#include "core/hand/mano_joints.h"

#include <array>
#include <numbers>

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

}  // namespace handgraft::hand
