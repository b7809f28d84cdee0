#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/hand/finger_coordinates.h"
#include "core/session/document.h"
#include "core/session/models.h"

namespace handgraft::session {

class WayTrials;

/// The demonstrator's digits, each on one of this hand's; what is missing goes without.
using Dealing = std::map<std::string, std::string>;

/// The ways to deal digits that touched, thumb to little, to a hand's: a thumb to a thumb and
/// the others in their order, a claw's the other way round, too. One at least. Cost: at most
/// some dozens of ways.
std::vector<Dealing> waysToDeal(const hand::Anatomy& anatomy,
                                std::vector<std::string> touching);

/// Whether a hand lacks any of a human's digits.
bool lacksDigits(const hand::Anatomy& anatomy);

/// A dealing with one more digit, on a finger that is free, the one of its name if that is; the
/// others stay. Nothing where none can take it.
std::optional<Dealing> extendedBy(const hand::Anatomy& anatomy,
                                  const std::string& digit,
                                  const Dealing& dealing);

/// Of a demonstrator's `digits` beside those that are dealt, how many could be, too, each
/// alone.
int neighboursServed(const hand::Anatomy& anatomy,
                     const std::vector<std::string>& digits,
                     const Dealing& dealing);

/// From thumb to little, others behind them by name; each once.
std::vector<std::string> inOrder(std::vector<std::string> digits);

/// Where on the hand that touched each patch of a document was; nothing: it is not known.
using PlacesOfPatches = std::vector<std::optional<hand::HandLocation>>;

/// Which of this hand's fingers takes the patches of which of the demonstrator's.
///
/// Each goes to the one of its name. Where the hand lacks one that touched, its thumb stays a
/// thumb and the others are dealt out anew in their order across the palm, so that least of
/// the patches is dropped or missed when it is solved, of a motion at all of its frames that
/// count; the document's notes tell it. `document`: its patches without a placement are to be
/// laid by `places`. Deterministic. Cost: where a finger is missing, 10 to 20 ms for each way
/// to deal, and where none of them reaches all patches as much as a solve for each: some 0.5 s
/// for a claw's twelve; of a motion at each of those frames.
Dealing dealFingers(const Models& models,
                    const hand::FingerCoordinates& coordinates,
                    const PlacesOfPatches& places,
                    WayTrials& trials,
                    Document& document,
                    const Progress& progress);

}  // namespace handgraft::session
