#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/base/pose.h"
#include "core/hand/kinematics.h"
#include "core/session/models.h"

namespace handgraft::bench {

/// What fingertip retargeting knows of a hand: its tips, the joints before them, its palm.
struct Fingertips {
  struct Tip {
    std::string digit;
    int link = 0;                                       ///< moved by the digit's last joint
    Eigen::Vector3d p_L = Eigen::Vector3d::Zero();      ///< middle of the pad, or the tip
    Eigen::Vector3d joint_L = Eigen::Vector3d::Zero();  ///< the last joint
  };

  std::vector<Tip> tips;
  int palm_link = 0;
  /// Palm frame: x along the fingers, y from the first finger to the last, z out of the palm.
  Pose X_LP = Pose::Identity();
  bool has_palm = false;  ///< two fingers beside the thumb, at least
};

Fingertips fingertipsOf(const hand::Hand& hand);

/// A human's fingertips and palm, where a pose puts them.
struct FingertipPose {
  struct Tip {
    std::string digit;
    Eigen::Vector3d p_W = Eigen::Vector3d::Zero();
    Eigen::Vector3d joint_W = Eigen::Vector3d::Zero();
  };

  std::vector<Tip> tips;
  Pose X_WP = Pose::Identity();
};

FingertipPose posed(const hand::HandModel& model,
                    const Fingertips& fingertips,
                    const hand::HandPose& pose);

// What is used today, on the same inputs. Both know the demonstrator's fingertips, and nothing
// of the object. Fingers are those of the same name.

/// Inverse kinematics of the fingertips, the root free: tips on tips, and with a tenth of their
/// weight the last joints on the last joints, which tells how a finger stands. Our solver, all
/// its starts, or from `before` alone: the answer to the frame before, in a motion.
/// Errors: InvalidInput if fewer than two digits have a name in common.
hand::HandPose fingertipKinematics(const hand::Hand& hand,
                                   const Fingertips& fingertips,
                                   const FingertipPose& human,
                                   const hand::HandPose* before = nullptr);

/// DexPilot's objective: vectors from the palm to the tips and between the tips as the human's,
/// those that are to close (below 5 cm) drawn together; solved by SLSQP as there, from four
/// starts (or from `before`, as above). Kinder than there: lengths are not scaled, since the
/// object is as large for both hands; the root goes where tips and palm fit the human's best.
/// Errors: as above; also if a palm has fewer than two fingers.
/// Source: Handa et al. 2020, "DexPilot", equations 3 to 6.
hand::HandPose dexPilot(const hand::Hand& hand,
                        const Fingertips& fingertips,
                        const FingertipPose& human,
                        const hand::HandPose* before = nullptr);

}  // namespace handgraft::bench
