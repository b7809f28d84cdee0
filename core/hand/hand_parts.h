#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/hand/contact_site.h"
#include "core/hand/hand_model.h"

namespace handgraft::hand {

/// Which finger each link belongs to, and which way along it the wrist lies.
///
/// Everything is said in the links' own frames, so that it holds at any pose.
/// Cost: some 20 ms, as skinReferencePose.
class HandParts {
 public:
  /// `sites` may be empty; a digit is called like the first of them that lies on it.
  HandParts(const HandModel& model, const std::vector<ContactSite>& sites);

  /// The part of each link: a digit's name (nameDigits), `palm` for what the digits spring
  /// from, also where it moves, `f<n>` for other chains on it, such as jaws that slide; empty
  /// for what carries the palm.
  [[nodiscard]] const std::vector<std::string>& names() const { return names_; }

  /// Unit tangent towards the wrist where the link touches something.
  ///
  /// The direction of the site that moves with the link, or else that of its finger's bone,
  /// laid into the plane; where the finger stands on the surface, that direction turned from
  /// the pad to `n_L` by the shortest way. Missing where neither is known. Frames: `n_L` is the
  /// hand's outward unit normal there, in the link's frame, and so is the result.
  [[nodiscard]] std::optional<Eigen::Vector3d> towardsWrist(int link,
                                                            const Eigen::Vector3d& n_L) const;

 private:
  /// What is known of a link's pad.
  struct Pad {
    Eigen::Vector3d n_L = Eigen::Vector3d::Zero();
    Eigen::Vector3d towards_wrist_L = Eigen::Vector3d::Zero();
  };

  std::vector<std::string> names_;
  std::vector<std::optional<Pad>> pads_;  ///< of each link
};

}  // namespace handgraft::hand
