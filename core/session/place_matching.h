#pragma once

#include "core/base/progress.h"
#include "core/hand/finger_coordinates.h"
#include "core/session/dealing.h"
#include "core/session/document.h"
#include "core/session/models.h"

namespace handgraft::session {

/// Where on a hand the patches of a document were that have no placement: what they say
/// (contact::Patch::place), or the segment in their name, or the finger in it where this hand
/// has fingers of such names and lacks one of them. Nothing for those that lie on a site by
/// name.
PlacesOfPatches placesIn(const Models& models,
                         const hand::FingerCoordinates& coordinates,
                         const Document& document);

/// Lays them at the same coordinates of this hand, or on the site of their finger where that
/// alone is known, fingers as they are dealt out (dealing.h). What goes without is dropped and
/// says why. Deterministic. Cost: some milliseconds, and that of the dealing.
void matchByPlace(const Models& models,
                  const hand::FingerCoordinates& coordinates,
                  const PlacesOfPatches& places,
                  WayTrials& trials,
                  Document& document,
                  const Progress& progress);

/// The placement at a site, with a direction that is a tangent of the skin.
transfer::PatchPlacement soundPlacementAt(const hand::Hand& hand,
                                          const hand::ContactSite& site);

/// Lays the patches that have a place in `places` as a dealing has their fingers, or says why
/// they are dropped.
void layDealt(const Models& models,
              const hand::FingerCoordinates& coordinates,
              const PlacesOfPatches& places,
              const Dealing& dealing,
              Document& document);

/// The links that a patch laid on `site` may slide on, a flag a link: of the palm, or of the
/// segment whose or whose site it is and those beside it on its digit. Longer fingers meet an
/// object elsewhere on their segments.
std::vector<char> linksOfSite(const hand::Hand& hand,
                              const hand::FingerCoordinates& coordinates,
                              const std::string& site);

}  // namespace handgraft::session
