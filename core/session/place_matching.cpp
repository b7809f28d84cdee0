#include "core/session/place_matching.h"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/geometry/tangent.h"
#include "core/hand/hand_parts.h"
#include "core/session/dealing.h"
#include "core/session/patch_names.h"

namespace handgraft::session {
namespace {

std::optional<transfer::PatchPlacement> placementIn(const hand::FingerCoordinates& coordinates,
                                                    hand::HandLocation place,
                                                    const Dealing& dealing) {
  if (place.digit != hand::kPalmPart) {
    const auto dealt = dealing.find(place.digit);
    if (dealt == dealing.end()) return std::nullopt;
    place.digit = dealt->second;
  }
  const auto spot = coordinates.spotAt(place);
  if (!spot) return std::nullopt;
  return transfer::PatchPlacement{spot->root_S, spot->direction_S};
}

bool isOfFingerAlone(const hand::HandLocation& place) {
  return place.digit != hand::kPalmPart && place.segment.empty();
}

const hand::ContactSite* siteNamed(const hand::Hand& hand, const std::string& name) {
  const auto site = std::find_if(hand.sites.begin(), hand.sites.end(), [&](const auto& one) {
    return one.name == name;
  });
  return site == hand.sites.end() ? nullptr : &*site;
}

/// Whether a hand has fingers that are called as people's are, and lacks one that touched.
bool lacksFinger(const hand::FingerCoordinates& coordinates, const Document& document) {
  const hand::Anatomy& anatomy = coordinates.anatomy();
  const bool names_them =
      std::any_of(anatomy.digits.begin(), anatomy.digits.end(), [](const auto& digit) {
        return digit.name != "thumb" && isFinger(digit.name);
      });
  return names_them && std::any_of(document.patches.begin(), document.patches.end(),
                                   [&](const DocumentPatch& patch) {
                                     return isFinger(patch.name) &&
                                            anatomy.maybeDigit(patch.name) == nullptr;
                                   });
}

/// Whether two segments of a digit are the same or one follows the other.
bool areNeighbours(const hand::NamedDigit& digit, const std::string& a, const std::string& b) {
  const auto rank = [&](const std::string& name) {
    return std::find_if(digit.segments.begin(), digit.segments.end(),
                        [&](const hand::Segment& segment) {
                          return segment.name == name;
                        }) -
           digit.segments.begin();
  };
  if (rank(a) == std::ssize(digit.segments)) return true;  // the digit alone is known
  return std::abs(rank(a) - rank(b)) <= 1;
}

}  // namespace

transfer::PatchPlacement soundPlacementAt(const hand::Hand& hand,
                                          const hand::ContactSite& site) {
  transfer::PatchPlacement placement = transfer::placementAt(*hand.model, *hand.skin, site);
  placement.direction_S = tangentAt(hand.skin->mesh(), placement.root_S, placement.direction_S)
                              .value_or(anyTangentAt(hand.skin->mesh(), placement.root_S));
  return placement;
}

PlacesOfPatches placesIn(const Models& models,
                         const hand::FingerCoordinates& coordinates,
                         const Document& document) {
  const bool deals_fingers = lacksFinger(coordinates, document);
  PlacesOfPatches places;
  for (const DocumentPatch& patch : document.patches) {
    std::optional<hand::HandLocation>& place = places.emplace_back();
    if (patch.placement) continue;
    const auto outline =
        std::find_if(models.contacts->patches.begin(), models.contacts->patches.end(),
                     [&](const contact::Patch& one) {
                       return one.name == patch.name;
                     });
    if (outline != models.contacts->patches.end()) place = outline->place;
    if (!place && deals_fingers && isFinger(patch.name)) {
      place.emplace();
      place->digit = patch.name;
    }
    if (!place && siteNamed(*models.hand, patch.name) == nullptr)
      place = hand::placeNamed(patch.name);
  }
  return places;
}

void layDealt(const Models& models,
              const hand::FingerCoordinates& coordinates,
              const PlacesOfPatches& places,
              const Dealing& dealing,
              Document& document) {
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (!places[i]) continue;
    DocumentPatch& patch = document.patches[i];
    const auto dealt = dealing.find(places[i]->digit);
    if (isOfFingerAlone(*places[i]) && dealt != dealing.end()) {
      const hand::ContactSite* site = siteNamed(*models.hand, dealt->second);
      if (site == nullptr) continue;  // the hand's other sites may do
      patch.placement = soundPlacementAt(*models.hand, *site);
      patch.site = site->name;
      patch.root_is_open = models.hand->sites_are_found;
      patch.dropped.clear();
      continue;
    }
    patch.placement = placementIn(coordinates, *places[i], dealing);
    if (patch.placement) {
      const auto link =
          models.hand->skin
              ->faceLinks()[static_cast<std::size_t>(patch.placement->root_S.face)];
      const auto& [digit, segment] = coordinates.parts()[static_cast<std::size_t>(link)];
      patch.site = hand::partName(digit, segment);
      patch.root_is_open = true;
      patch.dropped.clear();
      continue;
    }
    const std::string& digit = places[i]->digit;
    if (digit == hand::kPalmPart && !coordinates.anatomy().palm) continue;  // its site may do
    patch.dropped =
        dealing.contains(digit) || digit == hand::kPalmPart
            ? fmt::format("no place of the hand's skin is where {} was", quoted(patch.name))
            : fmt::format("hand has fewer fingers than touched: {} goes without one",
                          quoted(patch.name));
  }
}

void matchByPlace(const Models& models,
                  const hand::FingerCoordinates& coordinates,
                  const PlacesOfPatches& places,
                  WayTrials& trials,
                  Document& document,
                  const Progress& progress) {
  if (std::none_of(places.begin(), places.end(), [](const auto& place) {
        return place.has_value();
      }))
    return;
  layDealt(models, coordinates, places,
           dealFingers(models, coordinates, places, trials, document, progress), document);
}

std::vector<char> linksOfSite(const hand::Hand& hand,
                              const hand::FingerCoordinates& coordinates,
                              const std::string& site) {
  const auto& parts = coordinates.parts();
  std::string digit;
  std::string segment;
  if (const auto place = hand::placeNamed(site)) {
    digit = place->digit;
    segment = place->segment;
  }
  for (const hand::ContactSite& candidate : hand.sites) {
    if (candidate.name != site) continue;
    const auto& part = parts[static_cast<std::size_t>(hand.model->linkIndex(candidate.link))];
    digit = part.digit;
    segment = part.segment;
  }
  const hand::NamedDigit* named = coordinates.anatomy().maybeDigit(digit);
  std::vector<char> links(parts.size(), 0);
  for (std::size_t link = 0; link < links.size(); ++link) {
    const auto& part = parts[link];
    if (part.digit.empty()) continue;
    links[link] = hand::partName(part.digit, part.segment) == site ||
                  (part.digit == digit &&
                   (named == nullptr || areNeighbours(*named, segment, part.segment)));
  }
  return links;
}

}  // namespace handgraft::session
