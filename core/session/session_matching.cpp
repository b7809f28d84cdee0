#include <algorithm>

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/geometry/tangent.h"
#include "core/session/hand_placement.h"
#include "core/session/patch_names.h"
#include "core/session/session.h"
#include "core/session/site_assignment.h"

// Which patch belongs to which site of the hand.
namespace handgraft::session {

namespace {

/// The placement at a site, with a direction that is a tangent of the skin.
transfer::Placement soundPlacementAt(const Hand& hand, const hand::ContactSite& site) {
  transfer::Placement placement = transfer::placementAt(*hand.model, *hand.skin, site);
  placement.direction_S = tangentAt(hand.skin->mesh(), placement.root_S, placement.direction_S)
                              .value_or(anyTangentAt(hand.skin->mesh(), placement.root_S));
  return placement;
}

}  // namespace

void Session::matchByName() {
  for (SessionPatch& item : patches_) {
    for (const hand::ContactSite& site : hand_.sites) {
      if (site.name != item.patch.name) continue;
      item.site = site.name;
      item.placement = soundPlacementAt(hand_, site);
      item.root_is_open = hand_.sites_are_found;
    }
  }
}

void Session::matchByGeometry() {
  // === Who is left: patches and sites where at least one of the two has no finger's name
  std::vector<SessionPatch*> patches;
  std::vector<Anchor> patch_anchors;
  std::vector<Anchor> fixed;
  for (SessionPatch& item : patches_) {
    if (!item.placement) {
      patches.push_back(&item);
      patch_anchors.push_back(
          withObjectSide({}, item.patch, *object_O_, !item.direction_is_open));
    } else if (auto anchor = anchorAt(*hand_.skin, *item.placement)) {
      fixed.push_back(withObjectSide(*anchor, item.patch, *object_O_, !item.direction_is_open));
    }
  }
  std::vector<const hand::ContactSite*> sites;
  std::vector<Anchor> site_anchors;
  for (const hand::ContactSite& site : hand_.sites) {
    const bool is_taken = std::any_of(patches_.begin(), patches_.end(), [&](const auto& item) {
      return item.site == site.name;
    });
    const auto anchor = anchorAt(*hand_.skin, soundPlacementAt(hand_, site));
    if (is_taken || !anchor) continue;
    sites.push_back(&site);
    site_anchors.push_back(*anchor);
  }
  bool any = false;
  std::vector<std::vector<bool>> permitted;
  for (const SessionPatch* item : patches) {
    permitted.emplace_back();
    for (const hand::ContactSite* site : sites) {
      const bool may = isAnonymousPatch(item->patch.name) || isAnonymousSite(site->name);
      permitted.back().push_back(may);
      any = any || may;
    }
  }

  // === Their places, and who goes without
  std::vector<int> answer(patches.size(), -1);
  if (any) {
    answer = assignSites(placer(), hand_.model, fixed, patch_anchors, site_anchors, permitted,
                         X_WO_, Progress());
  }
  for (std::size_t i = 0; i < patches.size(); ++i) {
    SessionPatch& item = *patches[i];
    if (answer[i] >= 0) {
      item.site = sites[answer[i]]->name;
      item.placement = soundPlacementAt(hand_, *sites[answer[i]]);
      item.root_is_open = hand_.sites_are_found;
      notes_.push_back(fmt::format("{} laid on site '{}', the best assignment found",
                                   quoted(item.patch.name), item.site));
    } else if (isAnonymousPatch(item.patch.name)) {
      item.dropped = fmt::format("no site is left for {}; the hand's sites are {}",
                                 quoted(item.patch.name), namesOf(hand_.sites));
    } else {
      item.dropped = fmt::format("hand has no {}; its sites are {}", quoted(item.patch.name),
                                 namesOf(hand_.sites));
    }
  }
}

}  // namespace handgraft::session
