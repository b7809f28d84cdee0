#pragma once

#include "core/base/progress.h"
#include "core/hand/finger_coordinates.h"
#include "core/session/document.h"
#include "core/session/models.h"

namespace handgraft::session {

/// Lays the patches that say where on a hand they were (contact::Patch::place, or the segment
/// in their name), and are on no site by name, at the same coordinates of this hand.
///
/// Fingers go to those of the same name. Where the hand lacks one that touched, its fingers are
/// dealt out anew in their order across the palm, as they reach best by a short solve; what
/// goes without is dropped and says why, all of it told in the document's notes.
/// Deterministic. Cost: some milliseconds; with fingers missing, some 10 ms a way to deal.
void matchByPlace(const Models& models,
                  const hand::FingerCoordinates& coordinates,
                  Document& document,
                  const Progress& progress);

/// The links that a patch laid on `site` may slide on, a flag a link: of the palm, or of the
/// digit whose segment or site it is. Longer fingers meet an object elsewhere on their
/// segments.
std::vector<char> linksOfSite(const hand::Hand& hand,
                              const hand::FingerCoordinates& coordinates,
                              const std::string& site);

}  // namespace handgraft::session
