#include "core/session/dealing.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/base/error.h"
#include "core/hand/hand_location.h"
#include "core/session/best_way.h"
#include "core/session/place_matching.h"

namespace handgraft::session {
namespace {

constexpr std::array<const char*, 5> kOrder{"thumb", "index", "middle", "ring", "little"};

std::size_t rankOf(const std::string& digit) {
  return static_cast<std::size_t>(std::find(kOrder.begin(), kOrder.end(), digit) -
                                  kOrder.begin());
}

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

/// Fingers of a claw beside its thumb: it may stand the other way round.
constexpr std::size_t kClaw = hand::kClawDigits - 1;

/// The ways to give `touching` fingers to those of the hand that keep their order; a claw's the
/// other way round, too.
std::vector<Dealing> dealings(const std::vector<std::string>& touching,
                              const std::vector<std::string>& fingers) {
  std::vector<Dealing> all;
  const std::size_t count = std::min(touching.size(), fingers.size());
  for (const auto& from : waysToChoose(touching, count)) {
    for (const auto& to : waysToChoose(fingers, count)) {
      Dealing dealing;
      for (std::size_t i = 0; i < count; ++i)
        dealing[from[i]] = to[i];
      all.push_back(dealing);
      if (fingers.size() != kClaw || count != kClaw) continue;
      std::swap(dealing[from[0]], dealing[from[1]]);
      all.push_back(std::move(dealing));
    }
  }
  return all;
}

/// The digits that touched, thumb to little.
std::vector<std::string> digitsIn(const PlacesOfPatches& places) {
  std::vector<std::string> digits;
  for (const auto& place : places)
    if (place && place->digit != hand::kPalmPart) digits.push_back(place->digit);
  return inOrder(std::move(digits));
}

std::vector<Document> laidBy(const Models& models,
                             const hand::FingerCoordinates& coordinates,
                             const PlacesOfPatches& places,
                             const std::vector<Dealing>& dealings,
                             const Document& document) {
  std::vector<Document> ways;
  for (const Dealing& dealing : dealings) {
    ways.push_back(document);
    layDealt(models, coordinates, places, dealing, ways.back());
  }
  return ways;
}

}  // namespace

std::vector<std::string> inOrder(std::vector<std::string> digits) {
  std::vector<std::string> once;
  for (std::string& digit : digits)
    if (std::find(once.begin(), once.end(), digit) == once.end())
      once.push_back(std::move(digit));
  std::sort(once.begin(), once.end(), [](const auto& a, const auto& b) {
    return std::pair(rankOf(a), a) < std::pair(rankOf(b), b);
  });
  return once;
}

std::vector<Dealing> waysToDeal(const hand::Anatomy& anatomy,
                                std::vector<std::string> touching) {
  Dealing kept;
  if (anatomy.maybeDigit("thumb") != nullptr && std::erase(touching, "thumb") > 0)
    kept["thumb"] = "thumb";
  std::vector<std::string> fingers;
  for (const hand::NamedDigit& digit : anatomy.digits)
    if (digit.name != "thumb") fingers.push_back(digit.name);
  std::vector<Dealing> ways = dealings(touching, fingers);
  for (Dealing& way : ways)
    way.insert(kept.begin(), kept.end());
  return ways;
}

bool lacksDigits(const hand::Anatomy& anatomy) {
  return std::any_of(kOrder.begin(), kOrder.end(), [&](const char* digit) {
    return anatomy.maybeDigit(digit) == nullptr;
  });
}

std::optional<Dealing> extendedBy(const hand::Anatomy& anatomy,
                                  const std::string& digit,
                                  const Dealing& dealing) {
  std::vector<std::string> digits{digit};
  for (const auto& [from, to] : dealing)
    digits.push_back(from);
  std::optional<Dealing> found;
  for (Dealing& way : waysToDeal(anatomy, inOrder(std::move(digits)))) {
    const auto stays = [&](const auto& dealt) {
      const auto now = way.find(dealt.first);
      return now != way.end() && now->second == dealt.second;
    };
    const auto finger = way.find(digit);
    if (finger == way.end() || !std::all_of(dealing.begin(), dealing.end(), stays)) continue;
    const bool has_its_name = finger->second == digit;
    if (!found || has_its_name) found = std::move(way);
  }
  return found;
}

int neighboursServed(const hand::Anatomy& anatomy,
                     const std::vector<std::string>& digits,
                     const Dealing& dealing) {
  int count = 0;
  for (std::size_t rank = 1; rank < kOrder.size(); ++rank) {
    const std::string digit = kOrder[rank];
    const bool is_beside = !dealing.contains(digit) &&
                           std::find(digits.begin(), digits.end(), digit) != digits.end() &&
                           ((rank > 1 && dealing.contains(kOrder[rank - 1])) ||
                            (rank + 1 < kOrder.size() && dealing.contains(kOrder[rank + 1])));
    count += is_beside && extendedBy(anatomy, digit, dealing) ? 1 : 0;
  }
  return count;
}

Dealing dealFingers(const Models& models,
                    const hand::FingerCoordinates& coordinates,
                    const PlacesOfPatches& places,
                    WayTrials& trials,
                    Document& document,
                    const Progress& progress) {
  const hand::Anatomy& anatomy = coordinates.anatomy();
  const std::vector<std::string> touching = digitsIn(places);
  Dealing same;
  std::vector<std::string> missing;
  for (const std::string& digit : touching) {
    if (anatomy.maybeDigit(digit) != nullptr) {
      same[digit] = digit;
    } else {
      missing.push_back(digit);
    }
  }
  const bool is_claw = anatomy.digits.size() == hand::kClawDigits &&
                       touching.size() == hand::kClawDigits && same.contains("thumb");
  if (missing.empty() && !is_claw) return same;
  const std::vector<Dealing> ways = waysToDeal(anatomy, touching);
  const bool has_choice = ways.size() > 1;
  Dealing best =
      ways[trials.best(laidBy(models, coordinates, places, ways, document), false, progress)];
  for (const auto& [from, to] : best) {
    if (from == to) continue;
    std::string why;
    if (!missing.empty()) why = fmt::format("it has no {}", fmt::join(missing, ", "));
    if (has_choice)
      why += (why.empty() ? "" : ", and ") + std::string("of the ways tried this fits best");
    document.notes.push_back(fmt::format("{}'s contacts go to the hand's {}{}{}", from, to,
                                         why.empty() ? "" : ": ", why));
  }
  return best;
}

}  // namespace handgraft::session
