#include "core/session/place_matching.h"

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/hand/hand_parts.h"
#include "core/placement/hand_pose_guess.h"
#include "core/session/patch_names.h"

namespace handgraft::session {
namespace {

constexpr int kStartsEach = 3;  // of each way to deal out fingers
/// What a patch that goes without a place costs: as if it were 10 mm off.
constexpr double kDropped = 2.0;
constexpr std::array<const char*, 5> kOrder{"thumb", "index", "middle", "ring", "little"};

std::size_t rankOf(const std::string& digit) {
  return static_cast<std::size_t>(std::find(kOrder.begin(), kOrder.end(), digit) -
                                  kOrder.begin());
}

/// A digit of the demonstrator on one of this hand's; missing: it goes without.
using Dealing = std::map<std::string, std::string>;

struct Placed {
  DocumentPatch* patch;
  hand::HandLocation place;
};

/// Ways to choose `count` of `all`, in their order.
void choose(const std::vector<std::string>& all,
            std::size_t count,
            std::size_t from,
            std::vector<std::string>& chosen,
            std::vector<std::vector<std::string>>& ways) {
  if (chosen.size() == count) {
    ways.push_back(chosen);
    return;
  }
  for (std::size_t i = from; i + (count - chosen.size()) <= all.size(); ++i) {
    chosen.push_back(all[i]);
    choose(all, count, i + 1, chosen, ways);
    chosen.pop_back();
  }
}

std::vector<std::vector<std::string>> waysToChoose(const std::vector<std::string>& all,
                                                   std::size_t count) {
  std::vector<std::vector<std::string>> ways;
  std::vector<std::string> chosen;
  choose(all, std::min(count, all.size()), 0, chosen, ways);
  return ways;
}

/// The order-keeping ways to give `touching` fingers to those of the hand.
std::vector<Dealing> dealings(const std::vector<std::string>& touching,
                              const std::vector<std::string>& fingers) {
  std::vector<Dealing> all;
  const std::size_t count = std::min(touching.size(), fingers.size());
  for (const auto& from : waysToChoose(touching, count)) {
    for (const auto& to : waysToChoose(fingers, count)) {
      Dealing dealing;
      for (std::size_t i = 0; i < count; ++i)
        dealing[from[i]] = to[i];
      all.push_back(std::move(dealing));
    }
  }
  return all;
}

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

/// How well a dealing reaches: less is better.
double costOf(const Models& models,
              const placement::HandPoseGuesser& placer,
              const hand::FingerCoordinates& coordinates,
              const std::vector<Placed>& placed,
              const Dealing& dealing,
              const Pose& X_WO,
              const Progress& progress) {
  std::vector<placement::Anchor> anchors;
  double dropped = 0.0;
  for (const Placed& one : placed) {
    const auto placement = placementIn(coordinates, one.place, dealing);
    auto anchor =
        placement ? placement::anchorAt(*models.hand->skin, *placement) : std::nullopt;
    if (!anchor) {
      dropped += kDropped;
      continue;
    }
    contact::Patch side;
    side.root = one.patch->root_O;
    side.direction_O = one.patch->direction_O;
    anchors.push_back(placement::withObjectSide(*anchor, side, *models.object_O,
                                                side.direction_O.has_value()));
  }
  if (anchors.empty()) return std::numeric_limits<double>::infinity();
  return placer.place(anchors, X_WO, kStartsEach, progress).front().score + dropped;
}

/// Which finger takes whose patches.
Dealing deal(const Models& models,
             const hand::FingerCoordinates& coordinates,
             const std::vector<Placed>& placed,
             Document& document,
             const Progress& progress) {
  std::vector<std::string> touching;
  for (const Placed& one : placed) {
    const std::string& digit = one.place.digit;
    if (digit == hand::kPalmPart) continue;
    if (std::find(touching.begin(), touching.end(), digit) == touching.end())
      touching.push_back(digit);
  }
  std::stable_sort(touching.begin(), touching.end(), [](const auto& a, const auto& b) {
    return rankOf(a) < rankOf(b);
  });
  Dealing same;
  std::vector<std::string> missing;
  for (const std::string& digit : touching) {
    if (coordinates.anatomy().maybeDigit(digit) != nullptr) {
      same[digit] = digit;
    } else {
      missing.push_back(digit);
    }
  }
  if (missing.empty()) return same;

  // === A thumb stays a thumb where there is one; the others are dealt out anew
  std::vector<std::string> fingers;
  for (const hand::NamedDigit& digit : coordinates.anatomy().digits)
    fingers.push_back(digit.name);
  Dealing kept;
  if (same.contains("thumb")) {
    kept["thumb"] = "thumb";
    std::erase(touching, "thumb");
  }
  std::erase(fingers, "thumb");
  std::vector<Dealing> ways = dealings(touching, fingers);
  for (Dealing& way : ways)
    way.insert(kept.begin(), kept.end());
  if (ways.empty()) ways = {same};
  const placement::HandPoseGuesser placer(models.hand->model, *models.hand->skin,
                                          models.object_O);
  Dealing best = ways.front();
  double least = std::numeric_limits<double>::infinity();
  for (const Dealing& way : ways) {
    if (ways.size() == 1) break;
    progress.checkpoint();
    const double cost =
        costOf(models, placer, coordinates, placed, way, document.X_WO, progress);
    if (cost >= least) continue;
    least = cost;
    best = way;
  }
  for (const auto& [from, to] : best) {
    if (from == to) continue;
    document.notes.push_back(
        fmt::format("{}'s contacts go to the hand's {}: it has no {}, and so it reaches best",
                    from, to, fmt::join(missing, ", ")));
  }
  return best;
}

bool isSiteOf(const hand::Hand& hand, const std::string& name) {
  return std::any_of(hand.sites.begin(), hand.sites.end(), [&](const auto& site) {
    return site.name == name;
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

void matchByPlace(const Models& models,
                  const hand::FingerCoordinates& coordinates,
                  Document& document,
                  const Progress& progress) {
  std::vector<Placed> placed;
  for (DocumentPatch& patch : document.patches) {
    if (patch.placement) continue;
    const auto outline =
        std::find_if(models.contacts->patches.begin(), models.contacts->patches.end(),
                     [&](const contact::Patch& one) {
                       return one.name == patch.name;
                     });
    std::optional<hand::HandLocation> place;
    if (outline != models.contacts->patches.end()) place = outline->place;
    if (!place && !isSiteOf(*models.hand, patch.name)) place = hand::placeNamed(patch.name);
    if (place) placed.push_back({&patch, *place});
  }
  if (placed.empty()) return;
  const Dealing dealing = deal(models, coordinates, placed, document, progress);
  for (const Placed& one : placed) {
    DocumentPatch& patch = *one.patch;
    patch.placement = placementIn(coordinates, one.place, dealing);
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
    const std::string& digit = one.place.digit;
    if (digit == hand::kPalmPart && !coordinates.anatomy().palm) continue;  // its site may do
    patch.dropped =
        dealing.contains(digit) || digit == hand::kPalmPart
            ? fmt::format("no place of the hand's skin is where {} was", quoted(patch.name))
            : fmt::format("hand has fewer fingers than touched: {} goes without one",
                          quoted(patch.name));
  }
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
