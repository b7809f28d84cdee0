#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "core/hand/demonstrated_joints.h"
#include "core/hand/hand.h"
#include "core/hand/kinematics.h"

namespace handgraft::hand {

/// Where a hand holds what is small: the middle between its thumb's tip and the middle of the
/// other digits' tips; of a hand without a thumb, the middle of all tips. It lies alike on
/// hands of different proportions, as wrists and palms do not.
class GripPoint {
 public:
  /// Cost: forward kinematics, and the hand's anatomy if nobody has asked for it.
  explicit GripPoint(const Hand& hand);

  /// In the frame of the link poses. Nothing of a hand without digits.
  [[nodiscard]] std::optional<Eigen::Vector3d> at(const LinkPoses& X_AL) const;

 private:
  struct Tip {
    std::size_t link = 0;
    Eigen::Vector3d p_L = Eigen::Vector3d::Zero();
  };

  std::vector<Tip> thumbs_;
  std::vector<Tip> others_;
};

/// That of a human hand, in the frame of its joints.
Eigen::Vector3d gripPointOf(const JointPlaces& joints);

}  // namespace handgraft::hand
