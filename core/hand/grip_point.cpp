#include "core/hand/grip_point.h"

#include "core/hand/finger_coordinates.h"

namespace handgraft::hand {

GripPoint::GripPoint(const Hand& hand) {
  const LinkPoses X_SL =
      forwardKinematics(*hand.model, {Pose::Identity(), hand.skin->qReference()});
  for (const NamedDigit& digit : coordinatesOf(hand)->anatomy().digits) {
    if (digit.segments.empty()) continue;
    const Segment& last = digit.segments.back();
    const auto link = static_cast<std::size_t>(last.links.back());
    (digit.name == "thumb" ? thumbs_ : others_)
        .push_back({link, inverse(X_SL[link]) * last.end_S});
  }
}

std::optional<Eigen::Vector3d> GripPoint::at(const LinkPoses& X_AL) const {
  std::optional<Eigen::Vector3d> grip_A;
  for (const std::vector<Tip>* tips : {&thumbs_, &others_}) {
    if (tips->empty()) continue;
    Eigen::Vector3d middle_A = Eigen::Vector3d::Zero();
    for (const Tip& tip : *tips)
      middle_A += X_AL[tip.link] * tip.p_L;
    middle_A /= static_cast<double>(tips->size());
    grip_A = grip_A ? Eigen::Vector3d(0.5 * (*grip_A + middle_A)) : middle_A;
  }
  return grip_A;
}

Eigen::Vector3d gripPointOf(const JointPlaces& joints) {
  constexpr int kThumbTip = 4;
  constexpr int kFirstTip = 8;
  constexpr int kDigitJoints = 4;
  constexpr int kFingers = 4;
  Eigen::Vector3d fingers = Eigen::Vector3d::Zero();
  for (int finger = 0; finger < kFingers; ++finger)
    fingers += joints.col(kFirstTip + kDigitJoints * finger);
  return 0.5 * (joints.col(kThumbTip) + fingers / kFingers);
}

}  // namespace handgraft::hand
