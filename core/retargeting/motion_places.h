#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/hand/finger_coordinates.h"
#include "core/hand/kinematics.h"
#include "core/manipulation/motion.h"
#include "core/placement/open_roots.h"
#include "core/session/document.h"
#include "core/session/models.h"

namespace handgraft::retargeting {

/// Where the patches of a motion lie on the hand that follows it.
///
/// A patch on a site that somebody chose stays there (DocumentPatch::root_is_open).
class MotionPlaces {
 public:
  /// All outlive it. `document`: of the grasp that stands for the motion (graspOf), in the
  /// order of patchNames.
  MotionPlaces(const session::Document& document,
               const hand::Hand& hand,
               const geometry::TriangleMesh& object_O,
               const manipulation::Motion& motion);

  /// Whether any patch may slide.
  [[nodiscard]] bool any() const;

  /// What may not slide lies where the document has it, on a site or where somebody put it.
  void settle(manipulation::Motion& motion) const;

  /// That, and every other key's place: its own coordinates, on the finger that the document's
  /// matching dealt to the patch.
  void deal(manipulation::Motion& motion) const;

  /// Slides each key's patch along its finger to where the hand shows it in the middle of the
  /// time that the key holds, and turns it there (place_slider.h); true if any moved.
  /// `poses_O`: a pose a frame. Cost: some 20 us a key.
  bool slide(const std::vector<hand::HandPose>& poses_O, manipulation::Motion& motion) const;

 private:
  struct Patch {
    std::optional<transfer::PatchPlacement> placement;  ///< the document's
    bool slides = false;
    std::string digit;            ///< that it was dealt to; empty: a site's
    std::vector<char> permitted;  ///< links that it may slide on
  };

  const hand::Hand& hand_;
  const geometry::TriangleMesh& object_O_;
  hand::FingerCoordinates coordinates_;
  std::shared_ptr<const placement::SkinFaces> faces_;
  std::vector<Patch> patches_;  ///< of each track
};

}  // namespace handgraft::retargeting
