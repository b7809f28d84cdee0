#include "core/manipulation/transfer_patches.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "core/base/error.h"

namespace handgraft::manipulation {

namespace {

/// Why a key cannot be laid; empty where it can.
std::string faultOf(const PatchTrack& track,
                    const PatchKey& key,
                    const std::optional<transfer::PatchPlacement>& placement) {
  if (!track.dropped.empty()) return track.dropped;
  if (!key.patch.direction_O) return "it has no direction";
  if (!placement) return "this hand has no such place";
  return {};
}

optimize::PointPair pairOf(const transfer::Correspondence& one, int track) {
  optimize::PointPair pair;
  pair.link = one.link;
  pair.p_L = one.p_L;
  pair.n_L = one.n_L;
  pair.p_W = one.p_O;
  pair.n_W = one.n_O;
  pair.weight = one.weight;
  pair.patch = track;
  return pair;
}

/// How patches are laid onto a hand.
struct PatchLaying {
  const transfer::Surfaces& surfaces;
  const transfer::TransferOptions& options;
  const MovePlacement& move;
  bool as_drafts = false;
  int lost = 0;  ///< points that found no place

  /// Of the track's number in what is laid.
  std::vector<optimize::PointPair> pairsOf(const contact::Patch& patch,
                                           const transfer::PatchPlacement& placement,
                                           int track,
                                           transfer::StagedTransfer& stages) {
    const transfer::PatchTransfer transferred =
        stages.lay(surfaces, patch, move ? move(placement) : placement, options, as_drafts);
    lost += static_cast<int>(transferred.lost.size());
    std::vector<optimize::PointPair> pairs;
    for (const transfer::Correspondence& one : transferred.correspondences)
      pairs.push_back(pairOf(one, track));
    return pairs;
  }
};

}  // namespace

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
  if (auto placement = at(patch.place)) return placement;
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
  PatchLaying laying{surfaces, options, move, charts != nullptr && charts->uses_drafts};
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
      if (std::string why = faultOf(track, key, placement); !why.empty()) {
        fault = std::move(why);
      } else {
        span.pairs =
            laying.pairsOf(key.patch, *placement, static_cast<int>(laid.tracks.size()), stages);
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
  if (laying.lost > 0)
    laid.notes.push_back(fmt::format("{} points found no place on the hand", laying.lost));
  return laid;
}

}  // namespace handgraft::manipulation
