#pragma once

#include "core/base/progress.h"
#include "core/hand/finger_coordinates.h"
#include "core/session/dealing.h"
#include "core/session/document.h"
#include "core/session/models.h"

namespace handgraft::session {

/// Lays the patches that say where on a hand they were (contact::Patch::place, or the segment
/// in their name), and are on no site by name, at the same coordinates of this hand, fingers as
/// they are dealt out (dealing.h). What goes without is dropped and says why.
/// Deterministic. Cost: some milliseconds, and that of the dealing.
void matchByPlace(const Models& models,
                  const hand::FingerCoordinates& coordinates,
                  Document& document,
                  const Progress& progress);

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
