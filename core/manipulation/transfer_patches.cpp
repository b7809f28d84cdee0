#include "core/manipulation/transfer_patches.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "core/base/error.h"

namespace handgraft::manipulation {

std::optional<transfer::PatchPlacement> placementOf(
    const PatchKey& key,
    const transfer::Surfaces& surfaces,
    const hand::HandModel& model,
    const std::vector<hand::ContactSite>& sites,
    const hand::FingerCoordinates& coordinates) {
  if (key.placement) return key.placement;
  const contact::Patch& patch = key.patch;
  const auto at = [&](const std::optional<hand::HandLocation>& place)
      -> std::optional<transfer::PatchPlacement> {
    const auto spot = place ? coordinates.spotAt(*place) : std::nullopt;
    if (!spot) return std::nullopt;
    return transfer::PatchPlacement{spot->root_S, spot->direction_S};
  };
  if (const auto placement = at(patch.place)) return placement;
  const auto site = std::find_if(sites.begin(), sites.end(), [&](const hand::ContactSite& one) {
    return one.name == patch.name;
  });
  if (site != sites.end()) return transfer::placementAt(model, *surfaces.skin, *site);
  return at(hand::placeNamed(patch.name));
}

TransferredMotion transferPatches(const Motion& motion,
                                  const transfer::Surfaces& surfaces,
                                  const hand::HandModel& model,
                                  const std::vector<hand::ContactSite>& sites,
                                  const hand::FingerCoordinates& coordinates,
                                  const transfer::TransferOptions& options,
                                  const Progress& progress,
                                  const MovePlacement& move,
                                  MotionCharts* charts) {
  TransferredMotion laid;
  int lost = 0;
  if (charts != nullptr) charts->stages.resize(motion.tracks.size());
  for (std::size_t t = 0; t < motion.tracks.size(); ++t) {
    const PatchTrack& track = motion.tracks[t];
    PairTrack pairs;
    pairs.end = track.end;
    transfer::StagedTransfer from_key_to_key;
    std::string fault;
    std::size_t points = 0;
    if (charts != nullptr) charts->stages[t].resize(track.keys.size());
    for (std::size_t i = 0; i < track.keys.size(); ++i) {
      const PatchKey& key = track.keys[i];
      transfer::StagedTransfer& stages =
          charts != nullptr ? charts->stages[t][i] : from_key_to_key;
      progress.checkpoint();
      progress.report("laying patches",
                      static_cast<double>(t) / static_cast<double>(motion.tracks.size()));
      PairSpan span{key.frame, {}};
      const auto placement = placementOf(key, surfaces, model, sites, coordinates);
      if (!track.dropped.empty()) {
        fault = track.dropped;
      } else if (!key.patch.direction_O) {
        fault = "it has no direction";
      } else if (!placement) {
        fault = "this hand has no such place";
      } else {
        const transfer::PatchTransfer transferred =
            stages.lay(surfaces, key.patch, move ? move(*placement) : *placement, options,
                       charts != nullptr && charts->uses_drafts);
        lost += static_cast<int>(transferred.lost.size());
        for (const transfer::Correspondence& one : transferred.correspondences) {
          optimize::PointPair pair;
          pair.link = one.link;
          pair.p_L = one.p_L;
          pair.n_L = one.n_L;
          pair.p_W = one.p_O;
          pair.n_W = one.n_O;
          pair.weight = one.weight;
          pair.patch = static_cast<int>(laid.tracks.size());
          span.pairs.push_back(pair);
        }
      }
      points += span.pairs.size();
      pairs.spans.push_back(std::move(span));
    }
    if (!fault.empty())
      laid.notes.push_back(
          fmt::format("patch {} left out in part or whole: {}", quoted(track.name), fault));
    if (points == 0) continue;
    laid.tracks.push_back(std::move(pairs));
    laid.track_of.push_back(static_cast<int>(t));
  }
  if (laid.tracks.empty())
    rejectInput("motion '{}': no patch finds a place on hand '{}'", motion.name, model.name());
  if (lost > 0) laid.notes.push_back(fmt::format("{} points found no place on the hand", lost));
  return laid;
}

}  // namespace handgraft::manipulation
