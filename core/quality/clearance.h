#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "core/geometry/surface_locator.h"
#include "core/hand/skin.h"
#include "core/transfer/patch_placement.h"

namespace handgraft::quality {

struct Ball {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  double radius = 0.0;
};

/// The largest ball, up to radius `most`, that touches a surface at `p`, lies on the side that
/// the unit vector `n` points to, and enters the surface elsewhere by no more than `lift`.
///
/// `lift` makes bumps and facets of its height count for nothing; a wall at the far side takes
/// half of it from the radius.
/// Cost: some ten nearest-point queries. Source: Ma, Bae & Choi 2012, "3D medial axis point
/// approximation using nearest neighbors and the normal field" (shrinking balls).
Ball tangentBall(const geometry::SurfaceLocator& surface,
                 const Eigen::Vector3d& p,
                 const Eigen::Vector3d& n,
                 double most,
                 double lift);

/// What of a hand stands behind a place on its skin, whatever the pose: balls inside the link
/// there, in the contact frame C. Origin: the place on the link's own surface; z into the hand,
/// x along the placement's direction.
using ContactBody = std::vector<Ball>;

/// The body behind a placement: balls of the root's link within `kBodyReach` of the root's own
/// one. Empty where no link lies below the skin.
/// Cost: some 5 ms: nearest points are hard to tell where many are as near.
ContactBody bodyBehind(const hand::Skin& skin, const transfer::PatchPlacement& placement);

inline constexpr double kBodyReach = 0.010;  // m; a pad, and what is rigid with it

/// Where a contact shall be on an object.
struct ContactPlace {
  Eigen::Vector3d p_O = Eigen::Vector3d::Zero();
  Eigen::Vector3d n_O = Eigen::Vector3d::Zero();
  /// Unit tangent that the placement's direction shall meet; missing: any will do.
  std::optional<Eigen::Vector3d> direction_O;
};

/// A ball of 3 cm radius touches there and nowhere else: clearance for any finger. Cost: 20 us.
bool isOpen(const geometry::SurfaceLocator& object_O, const ContactPlace& place);

/// How far a body has to enter the object wherever, within the slack of a contact, it touches.
///
/// The slack: the contact slides up to 2 mm, the body turns about the normal by up to 30
/// degrees (all round where the direction is open), tilts by up to 10, and stands off by up to
/// 1 mm. The least depth over all of it, m; 0 where it is no more than 0.1 mm.
///
/// A necessary condition for a grasp without penetration, of this contact alone: a hand that
/// has clearance at each may still find no pose.
/// Cost: 0.1 ms where there is clearance at once, up to 10 ms where there is none.
double missingClearance(const geometry::SurfaceLocator& object_O,
                        const ContactBody& body,
                        const ContactPlace& place);

/// So much of missing clearance is told: what meshes of the usual fineness may be off by. A
/// body misses what it enters at the least, so that it errs on the side of silence.
inline constexpr double kToldMissing = 0.0002;  // m

}  // namespace handgraft::quality
