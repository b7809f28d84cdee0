#include "core/session/dealing.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <memory>
#include <tuple>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/base/error.h"
#include "core/hand/hand_location.h"
#include "core/session/derived_state.h"
#include "core/session/place_matching.h"

namespace handgraft::session {
namespace {

constexpr int kShortStarts = 4;

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
  for (const auto& place : places) {
    if (!place || place->digit == hand::kPalmPart) continue;
    if (std::find(digits.begin(), digits.end(), place->digit) == digits.end())
      digits.push_back(place->digit);
  }
  std::stable_sort(digits.begin(), digits.end(), [](const auto& a, const auto& b) {
    return rankOf(a) < rankOf(b);
  });
  return digits;
}

/// Patches that an answer lacks, those that are dropped of them, and the objective: less is
/// better. Of as many, what is missed may be reached yet, what is dropped never.
using Lack = std::tuple<std::ptrdiff_t, std::ptrdiff_t, double>;

/// A way to deal, and what comes of it.
struct Way {
  Dealing dealing;
  Document document;  ///< laid so
  Lack lack;
  bool reaches_all = false;
};

std::vector<Way> waysToLay(const Models& models,
                           const hand::FingerCoordinates& coordinates,
                           const PlacesOfPatches& places,
                           const std::vector<Dealing>& dealings,
                           const Document& document) {
  std::vector<Way> ways;
  for (const Dealing& dealing : dealings) {
    Way& way = ways.emplace_back(Way{dealing, document, {}});
    layDealt(models, coordinates, places, dealing, way.document);
  }
  return ways;
}

std::ptrdiff_t droppedPatches(const Document& document) {
  return std::count_if(document.patches.begin(), document.patches.end(),
                       [](const DocumentPatch& patch) {
                         return !patch.placement;
                       });
}

Lack lackOf(const Solution& solution) {
  const std::ptrdiff_t dropped = droppedPatches(solution.document);
  return {dropped + failedPatches(solution.problem, solution.report), dropped,
          solution.report.terms.objective};
}

/// What comes of each way by `solve`, the best of them put first; a way that leaves no point
/// comes to nothing. Ways that drop more patches than another one lacks are not looked at.
template <class Solve>
void judge(std::vector<Way>& ways, const Solve& solve) {
  std::ptrdiff_t least = std::numeric_limits<std::ptrdiff_t>::max();
  for (Way& way : ways) {
    const std::ptrdiff_t dropped = droppedPatches(way.document);
    way.lack = {std::ssize(way.document.patches), dropped,
                std::numeric_limits<double>::infinity()};
    if (dropped > least) continue;
    try {
      const Solution solution = solve(way.document);
      way.lack = lackOf(solution);
      way.reaches_all = failedPatches(solution.problem, solution.report) == 0;
    } catch (const InvalidInput&) {
      continue;
    }
    least = std::min(least, std::get<0>(way.lack));
  }
  std::stable_sort(ways.begin(), ways.end(), [](const Way& a, const Way& b) {
    return a.lack < b.lack;
  });
}

std::shared_ptr<ModelCache> cacheOf(const Models& models, const Document& document) {
  SessionModels known;
  known.hand_name = document.hand;
  known.hand = *models.hand;
  known.object_name = document.object;
  known.object_O = models.object_O;
  known.contacts_name = document.contacts;
  known.contacts = models.contacts;
  return std::make_shared<ModelCache>(std::move(known));
}

/// The way that lacks least: by a short search, and where that misses any, by a full one of
/// each, since the short one is no guide then (DECISIONS.md).
Dealing bestOf(const Models& models, std::vector<Way> ways, const Progress& progress) {
  if (ways.size() == 1) return ways.front().dealing;
  DerivedState derived(cacheOf(models, ways.front().document));
  SolverSettings solving = ways.front().document.solving;
  solving.starts = kShortStarts;
  judge(ways, [&](const Document& document) {
    derived.follow(document, progress);
    return derived.solveRoughly(solving, progress);
  });
  if (ways.front().reaches_all) return ways.front().dealing;
  solving = ways.front().document.solving;
  judge(ways, [&](const Document& document) {
    derived.follow(document, progress);
    return derived.solve(solving, {}, progress);
  });
  return ways.front().dealing;
}

}  // namespace

Dealing dealFingers(const Models& models,
                    const hand::FingerCoordinates& coordinates,
                    const PlacesOfPatches& places,
                    Document& document,
                    const Progress& progress) {
  std::vector<std::string> touching = digitsIn(places);
  Dealing same;
  std::vector<std::string> missing;
  for (const std::string& digit : touching) {
    if (coordinates.anatomy().maybeDigit(digit) != nullptr) {
      same[digit] = digit;
    } else {
      missing.push_back(digit);
    }
  }
  std::vector<std::string> fingers;
  for (const hand::NamedDigit& digit : coordinates.anatomy().digits)
    fingers.push_back(digit.name);
  const bool is_claw = fingers.size() == kClaw + 1 && touching.size() == fingers.size() &&
                       same.contains("thumb");
  if (missing.empty() && !is_claw) return same;

  // === A thumb stays a thumb where there is one; the others are dealt out anew
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
  const bool has_choice = ways.size() > 1;
  Dealing best =
      bestOf(models, waysToLay(models, coordinates, places, ways, document), progress);
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
