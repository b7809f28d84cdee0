#include "core/session/leave_out.h"

#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/hand/hand_parts.h"
#include "core/session/best_way.h"

namespace handgraft::session {
namespace {

constexpr int kMostRounds = 2;
constexpr std::size_t kMostTried = 4;  // in full, the best by short searches
// Of a tripod grasp none goes: that would not be the same grasp any more.
constexpr std::ptrdiff_t kFewestLeft = 3;
constexpr std::ptrdiff_t kFewestBesidePalm = 2;

std::string digitOf(const DocumentPatch& patch) {
  const auto place = hand::placeNamed(patch.site);
  return place ? place->digit : patch.site;
}

std::ptrdiff_t laidIn(const Document& document) {
  return std::count_if(document.patches.begin(), document.patches.end(),
                       [](const DocumentPatch& patch) {
                         return patch.enabled && patch.placement;
                       });
}

/// Numbers of patches that are laid on a digit or the palm.
std::vector<std::size_t> laidOn(const std::string& digit, const Document& document) {
  std::vector<std::size_t> patches;
  for (std::size_t i = 0; i < document.patches.size(); ++i)
    if (document.patches[i].placement && digitOf(document.patches[i]) == digit)
      patches.push_back(i);
  return patches;
}

using Group = std::vector<std::size_t>;

/// One patch of a finger each.
std::vector<Group> patchesOfFingers(const Document& document) {
  const bool has_one_of_thumb = laidOn("thumb", document).size() == 1;
  std::vector<Group> groups;
  for (std::size_t i = 0; i < document.patches.size(); ++i) {
    const DocumentPatch& patch = document.patches[i];
    if (!patch.placement) continue;
    const std::string digit = digitOf(patch);
    if (digit != hand::kPalmPart && !(digit == "thumb" && has_one_of_thumb))
      groups.push_back({i});
  }
  return groups;
}

Document without(const Group& group, Document document) {
  for (const std::size_t i : group) {
    DocumentPatch& patch = document.patches[i];
    patch.placement.reset();
    patch.dropped = fmt::format(
        "without {} the hand reaches more of the others (a root on the hand brings it back)",
        quoted(patch.name));
    document.notes.push_back(patch.dropped);
  }
  return document;
}

/// Leaves out the group without which the document lacks least, if that is less than with it.
bool leaveOneOut(const std::vector<Group>& groups,
                 std::ptrdiff_t fewest_left,
                 const std::vector<char>& may_go,
                 WayTrials& trials,
                 Document& document,
                 const Progress& progress) {
  const std::ptrdiff_t missed = trials.missedBySearch(document, progress);
  std::vector<Document> shortened;
  for (const Group& group : groups) {
    const bool may_all = std::all_of(group.begin(), group.end(), [&](std::size_t i) {
      return may_go[i] != 0;
    });
    // What goes is lacking: as many as are missed bring nothing.
    if (group.empty() || std::ssize(group) >= missed || !may_all) continue;
    Document one = without(group, document);
    if (laidIn(one) >= fewest_left) shortened.push_back(std::move(one));
  }
  if (shortened.empty()) return false;
  std::vector<Document> ways{document};
  for (const std::size_t way : trials.likely(shortened, kMostTried, progress))
    ways.push_back(std::move(shortened[way]));
  const std::size_t best = trials.bestSolved(ways, progress);
  document = std::move(ways[best]);
  return best > 0;
}

}  // namespace

void leaveOutWhatKeepsOthersOff(const std::vector<char>& may_go,
                                WayTrials& trials,
                                Document& document,
                                const Progress& progress) {
  HANDGRAFT_REQUIRE(may_go.size() == document.patches.size());
  const auto misses = [&] {
    return laidIn(document) > kFewestBesidePalm &&
           trials.missedBySearch(document, progress) > 0;
  };
  if (!misses()) return;
  // Fingers first: the palm's goes before any of theirs.
  if (leaveOneOut({laidOn(hand::kPalmPart, document)}, kFewestBesidePalm, may_go, trials,
                  document, progress) &&
      !misses())
    return;
  for (int round = 0; round < kMostRounds; ++round) {
    if (!leaveOneOut(patchesOfFingers(document), kFewestLeft, may_go, trials, document,
                     progress))
      return;
    if (!misses()) return;
  }
}

}  // namespace handgraft::session
