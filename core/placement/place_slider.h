#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "core/hand/finger_coordinates.h"
#include "core/hand/kinematics.h"
#include "core/placement/open_roots.h"
#include "core/transfer/patch_placement.h"

namespace handgraft::placement {

/// A point that a slide loses at the skin's rim costs as if it were so far off.
inline constexpr double kLost = 0.01;  // m

/// A contact as an object has it, in W.
struct ContactAt {
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();
  Eigen::Vector3d n_W = Eigen::Vector3d::Zero();  ///< the object's outward unit normal
  std::optional<Eigen::Vector3d> d_W;             ///< its direction; missing: none to turn to
};

/// A patch's place on a hand, slid to where a pose shows the contact, and turned there as it
/// shows the direction, by an eighth of a turn from the bone at most. Nothing where neither is
/// more than a face or some degrees.
///
/// `X_SW`: Skin::fromWorld of the pose. `permitted`: links that it may slide on, a flag a link.
/// Cost: some 20 us.
std::optional<transfer::PatchPlacement> slidPlace(const SkinFaces& faces,
                                                  const hand::FingerCoordinates& coordinates,
                                                  const hand::LinkPoses& X_SW,
                                                  const std::vector<char>& permitted,
                                                  const ContactAt& contact,
                                                  const transfer::PatchPlacement& placement);

}  // namespace handgraft::placement
