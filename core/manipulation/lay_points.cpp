#include "core/manipulation/lay_points.h"

#include <algorithm>
#include <utility>

#include "core/base/error.h"

namespace handgraft::manipulation {

std::vector<PairTrack> layPoints(const Motion& motion,
                                 const geometry::TriangleMesh& object_O,
                                 const hand::HandModel& model) {
  std::vector<PairTrack> tracks;
  std::string unknown;
  for (const PatchTrack& track : motion.tracks) {
    PairTrack laid;
    laid.end = track.end;
    bool any = false;
    for (const PatchKey& key : track.keys) {
      PairSpan span{key.frame, {}};
      for (std::size_t i = 0; i < key.hand_points.size(); ++i) {
        const auto link = model.maybeLinkIndex(key.hand_points[i].link);
        if (!link) {
          unknown = key.hand_points[i].link;
          continue;
        }
        optimize::PointPair pair;
        pair.link = *link;
        pair.p_L = key.hand_points[i].p_L;
        pair.p_W = positionOf(object_O, key.patch.interpolation_boundary[i]);
        pair.n_W = normalOf(object_O, key.patch.interpolation_boundary[i]);
        pair.weight =
            key.patch.weight * std::max(1.0, contact::kDefaultInterpolationCount /
                                                 static_cast<double>(key.hand_points.size()));
        pair.patch = static_cast<int>(tracks.size());
        pair.n_L = Eigen::Vector3d::UnitZ();  // a unit vector that counts for nothing
        pair.has_normals = false;
        span.pairs.push_back(pair);
        any = true;
      }
      laid.spans.push_back(std::move(span));
    }
    if (any) tracks.push_back(std::move(laid));
  }
  if (tracks.empty()) {
    rejectInput("motion '{}' has no point on a link of hand '{}'{}", motion.name, model.name(),
                unknown.empty() ? "" : "; one lies on " + quoted(unknown));
  }
  return tracks;
}

}  // namespace handgraft::manipulation
