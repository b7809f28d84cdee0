#include "core/retargeting/motion_places.h"

#include <algorithm>

#include "core/placement/place_slider.h"
#include "core/retargeting/motion_solving.h"
#include "core/session/place_matching.h"

namespace handgraft::retargeting {

MotionPlaces::MotionPlaces(const session::Document& document,
                           const hand::Hand& hand,
                           const geometry::TriangleMesh& object_O,
                           const manipulation::Motion& motion)
    : hand_(hand),
      object_O_(object_O),
      coordinates_(*hand.model, *hand.skin, hand.sites),
      faces_(placement::facesOf(hand.skin)) {
  const std::vector<std::string> names = patchNames(motion);
  for (const manipulation::PatchTrack& track : motion.tracks) {
    const auto index = static_cast<std::size_t>(
        std::find(names.begin(), names.end(), track.name) - names.begin());
    Patch& patch = patches_.emplace_back();
    if (index >= document.patches.size()) continue;
    const session::DocumentPatch& of_document = document.patches[index];
    if (!of_document.placement) continue;
    patch.placement = of_document.placement;
    patch.slides = of_document.root_is_open;
    if (!patch.slides) continue;
    if (const auto onto = hand::placeNamed(of_document.site)) patch.digit = onto->digit;
    patch.permitted = session::linksOfSite(hand, coordinates_, of_document.site);
  }
}

bool MotionPlaces::any() const {
  return std::any_of(patches_.begin(), patches_.end(), [](const Patch& patch) {
    return patch.slides;
  });
}

void MotionPlaces::settle(manipulation::Motion& motion) const {
  for (std::size_t t = 0; t < patches_.size(); ++t) {
    if (!patches_[t].placement || patches_[t].slides) continue;
    for (manipulation::PatchKey& key : motion.tracks[t].keys)
      key.placement = patches_[t].placement;
  }
}

void MotionPlaces::deal(manipulation::Motion& motion) const {
  settle(motion);
  for (std::size_t t = 0; t < patches_.size(); ++t) {
    const Patch& patch = patches_[t];
    if (!patch.slides) continue;
    for (manipulation::PatchKey& key : motion.tracks[t].keys) {
      key.placement = patch.placement;
      if (!key.patch.place || patch.digit.empty()) continue;
      hand::HandLocation place = *key.patch.place;
      if (place.digit != hand::kPalmPart) place.digit = patch.digit;
      if (const auto spot = coordinates_.spotAt(place))
        key.placement = transfer::PatchPlacement{spot->root_S, spot->direction_S};
    }
  }
}

bool MotionPlaces::slide(const std::vector<hand::HandPose>& poses_O,
                         manipulation::Motion& motion) const {
  bool any = false;
  for (std::size_t t = 0; t < patches_.size(); ++t) {
    if (!patches_[t].slides) continue;
    manipulation::PatchTrack& track = motion.tracks[t];
    for (std::size_t i = 0; i < track.keys.size(); ++i) {
      manipulation::PatchKey& key = track.keys[i];
      if (!key.placement) continue;
      const int end = i + 1 < track.keys.size() ? track.keys[i + 1].frame : track.end;
      const auto middle = static_cast<std::size_t>((key.frame + end - 1) / 2);
      placement::ContactAt contact;
      contact.p_W = positionOf(object_O_, key.patch.root);
      contact.n_W = normalOf(object_O_, key.patch.root);
      contact.d_W = key.patch.direction_O;
      const auto slid = placement::slidPlace(
          *faces_, coordinates_, hand_.skin->fromWorld(*hand_.model, poses_O[middle]),
          patches_[t].permitted, contact, *key.placement);
      if (!slid) continue;
      key.placement = slid;
      any = true;
    }
  }
  return any;
}

}  // namespace handgraft::retargeting
