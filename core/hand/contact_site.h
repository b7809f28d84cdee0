#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/hand/hand_model.h"
#include "core/hand/skin.h"

namespace handgraft::hand {

/// A named place of a hand where a patch belongs when the user says nothing: a finger pad, the
/// palm. Names are `thumb`, `index`, `middle`, `ring`, `little`, `palm`; `f1`..`fn` where the
/// layout allows no such name.
struct ContactSite {
  std::string name;
  std::string link;
  Eigen::Vector3d p_L = Eigen::Vector3d::Zero();
  /// Outward unit normal of the pad.
  Eigen::Vector3d n_L = Eigen::Vector3d::Zero();
  /// Unit tangent, pointing along the finger towards the wrist (for the palm: from the fingers
  /// towards the wrist). A patch's direction on the object means the same, so the two are laid
  /// onto each other.
  Eigen::Vector3d direction_L = Eigen::Vector3d::Zero();

  friend bool operator==(const ContactSite&, const ContactSite&) = default;
};

/// Checks names, links, unit vectors, and that a site is within 20 mm of the box around its
/// link's surface. InvalidInput names the site.
void validate(const HandModel& model, const std::vector<ContactSite>& sites);

/// Sites of a hand that brings none: fingertip pads on the flexion side of the leaf links, the
/// palm on the root's facing side, the thumb told apart by its base and closing direction.
///
/// Deterministic; needs the skin for places and normals. May find fewer sites than fingers: the
/// caller reports patches that find no site. Cost: a few milliseconds.
std::vector<ContactSite> findContactSites(const HandModel& model, const Skin& skin);

}  // namespace handgraft::hand
