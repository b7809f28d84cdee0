#include "core/manipulation/transfer_points.h"

#include <algorithm>
#include <iterator>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <fmt/ranges.h>

#include "core/base/error.h"

namespace handgraft::manipulation {

namespace {

/// Of each of `count` points: a recorded point stands for a region.
double pointWeight(const contact::Patch& patch, std::size_t count) {
  return patch.weight *
         std::max(1.0, contact::kDefaultInterpolationCount / static_cast<double>(count));
}

/// Where on the links a key's points lie, of those that tell a place: where they were found,
/// else there; nothing if the hand has none.
std::optional<hand::LinkPoint> linkPointAt(const PatchKey& key,
                                           const hand::Skin& skin,
                                           const hand::FingerCoordinates& coordinates) {
  if (!key.patch.place) return std::nullopt;
  if (key.placement) return skin.project(key.placement->root_S);
  const auto spot = coordinates.spotAt(*key.patch.place);
  if (!spot) return std::nullopt;
  return skin.project(spot->root_S);
}

/// Why a hand has no place for any of a motion's points.
std::string whyNothingIsLaid(const Motion& motion, const hand::HandModel& model) {
  std::set<std::string> links;
  for (const PatchTrack& track : motion.tracks)
    for (const PatchKey& key : track.keys)
      for (const HandPoint& point : key.hand_points)
        links.insert(quoted(point.link));
  if (links.empty())
    return fmt::format("none of its points has a place on hand {}", quoted(model.name()));
  constexpr std::size_t kMostShown = 3;
  const std::vector<std::string> shown(
      links.begin(), std::next(links.begin(), static_cast<std::ptrdiff_t>(
                                                  std::min(kMostShown, links.size()))));
  return fmt::format(
      "its points were recorded on {}, whose links ({}{}) hand {} has not, and nothing tells "
      "their places on other hands; take a recording of MANO's, or of areas",
      motion.hand.empty() ? "a hand" : "hand " + quoted(motion.hand), fmt::join(shown, ", "),
      links.size() > kMostShown ? ", ..." : "", quoted(model.name()));
}

}  // namespace

TransferredMotion transferPoints(const Motion& motion,
                                 const geometry::TriangleMesh& object_O,
                                 const hand::HandModel& model) {
  TransferredMotion laid;
  std::string unknown;
  std::set<std::string> lacking;
  for (std::size_t t = 0; t < motion.tracks.size(); ++t) {
    const PatchTrack& track = motion.tracks[t];
    PairTrack pairs;
    pairs.end = track.end;
    bool any = false;
    for (const PatchKey& key : track.keys) {
      PairSpan span{key.frame, {}};
      if (key.hand_points.empty()) lacking.insert(track.name);
      for (std::size_t i = 0; i < key.hand_points.size(); ++i) {
        const auto link = model.maybeLinkIndex(key.hand_points[i].link);
        if (!link) {
          unknown = key.hand_points[i].link;
          lacking.insert(track.name);
          continue;
        }
        optimize::PointPair pair;
        pair.link = *link;
        pair.p_L = key.hand_points[i].p_L;
        pair.p_W = positionOf(object_O, key.patch.interpolation_boundary[i]);
        pair.n_W = normalOf(object_O, key.patch.interpolation_boundary[i]);
        pair.weight = pointWeight(key.patch, key.hand_points.size());
        pair.patch = static_cast<int>(laid.tracks.size());
        pair.n_L = Eigen::Vector3d::UnitZ();  // a unit vector that counts for nothing
        pair.has_normals = false;
        span.pairs.push_back(pair);
        any = true;
      }
      pairs.spans.push_back(std::move(span));
    }
    if (!any) continue;
    laid.tracks.push_back(std::move(pairs));
    laid.track_of.push_back(static_cast<int>(t));
  }
  if (laid.tracks.empty()) {
    rejectInput("motion '{}' has no point on a link of hand '{}'{}", motion.name, model.name(),
                unknown.empty() ? "" : "; one lies on " + quoted(unknown));
  }
  for (const std::string& name : lacking) {
    laid.notes.push_back(
        fmt::format("points of {} left out in part or whole: they are on no link of this hand",
                    quoted(name)));
  }
  return laid;
}

TransferredMotion transferPointsByPlace(const Motion& motion,
                                        const geometry::TriangleMesh& object_O,
                                        const hand::HandModel& model,
                                        const hand::Skin& skin,
                                        const hand::FingerCoordinates& coordinates,
                                        const Progress& progress) {
  TransferredMotion laid;
  std::set<std::string> lacking;
  std::vector<std::string> dropped;
  for (std::size_t t = 0; t < motion.tracks.size(); ++t) {
    progress.checkpoint();
    progress.report("laying points",
                    static_cast<double>(t) / static_cast<double>(motion.tracks.size()));
    const PatchTrack& track = motion.tracks[t];
    // Its own finger may have been dealt another one's contacts.
    if (!track.dropped.empty()) {
      dropped.push_back(
          fmt::format("patch {} left out: {}", quoted(track.name), track.dropped));
      continue;
    }
    PairTrack pairs;
    pairs.end = track.end;
    bool any = false;
    for (const PatchKey& key : track.keys) {
      PairSpan span{key.frame, {}};
      if (const auto spot = linkPointAt(key, skin, coordinates)) {
        for (const geometry::SurfacePoint& point : key.patch.interpolation_boundary) {
          optimize::PointPair pair;
          pair.link = spot->link;
          pair.p_L = spot->p_L;
          pair.n_L = spot->n_L;
          pair.p_W = positionOf(object_O, point);
          pair.n_W = normalOf(object_O, point);
          pair.weight = pointWeight(key.patch, key.patch.interpolation_boundary.size());
          pair.patch = static_cast<int>(laid.tracks.size());
          span.pairs.push_back(pair);
          any = true;
        }
      } else {
        lacking.insert(track.name);
      }
      pairs.spans.push_back(std::move(span));
    }
    if (!any) continue;
    laid.tracks.push_back(std::move(pairs));
    laid.track_of.push_back(static_cast<int>(t));
  }
  if (laid.tracks.empty())
    rejectInput("motion {}: {}", quoted(motion.name), whyNothingIsLaid(motion, model));
  laid.notes = std::move(dropped);
  for (const std::string& name : lacking)
    laid.notes.push_back(fmt::format(
        "points of {} left out in part or whole: this hand has no such place", quoted(name)));
  return laid;
}

}  // namespace handgraft::manipulation
