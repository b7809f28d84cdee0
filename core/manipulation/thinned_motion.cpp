#include "core/manipulation/thinned_motion.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "core/base/error.h"
#include "core/manipulation/trajectory.h"

namespace handgraft::manipulation {

ThinnedMotion thinned(const Motion& motion, int stride) {
  HANDGRAFT_REQUIRE(stride > 0);
  ThinnedMotion thin;
  const int count = motion.frameCount();
  for (int k = 0; k < count; k += stride)
    thin.frames.push_back(k);
  if (count > 0) thin.frames.push_back(count - 1);
  for (const PatchTrack& track : motion.tracks)
    thin.frames.push_back(track.begin());
  std::sort(thin.frames.begin(), thin.frames.end());
  thin.frames.erase(std::unique(thin.frames.begin(), thin.frames.end()), thin.frames.end());
  thin.motion.name = motion.name;
  thin.motion.object = motion.object;
  thin.motion.hand = motion.hand;
  thin.motion.side = motion.side;
  for (const int k : thin.frames) {
    thin.motion.time_s.push_back(motion.time_s[static_cast<std::size_t>(k)]);
    thin.motion.X_WO.push_back(motion.X_WO[static_cast<std::size_t>(k)]);
  }
  // The first frame that is kept and not before `k`.
  const auto kept_from = [&](int k) {
    return static_cast<int>(std::lower_bound(thin.frames.begin(), thin.frames.end(), k) -
                            thin.frames.begin());
  };
  for (const PatchTrack& whole : motion.tracks) {
    PatchTrack track;
    track.name = whole.name;
    track.dropped = whole.dropped;
    track.end = kept_from(whole.end);
    std::vector<int> keys;
    for (std::size_t i = 0; i < whole.keys.size(); ++i) {
      const int frame = kept_from(whole.keys[i].frame);
      if (frame >= track.end) break;
      if (!track.keys.empty() && track.keys.back().frame == frame) {
        track.keys.pop_back();
        keys.pop_back();
      }
      track.keys.push_back(whole.keys[i]);
      track.keys.back().frame = frame;
      keys.push_back(static_cast<int>(i));
    }
    thin.motion.tracks.push_back(std::move(track));
    thin.keys.push_back(std::move(keys));
  }
  for (const DemonstratorKey& key : motion.demonstrator) {
    const int frame = kept_from(key.frame);
    std::vector<DemonstratorKey>& keys = thin.motion.demonstrator;
    if (!keys.empty() && keys.back().frame == frame) keys.pop_back();
    keys.push_back(key);
    keys.back().frame = frame;
  }
  return thin;
}

bool ThinnedMotion::hasAllKeys(const Motion& whole) const {
  return std::equal(keys.begin(), keys.end(), whole.tracks.begin(), whole.tracks.end(),
                    [](const std::vector<int>& kept, const PatchTrack& track) {
                      return kept.size() == track.keys.size();
                    });
}

void takePlacements(const ThinnedMotion& thin, Motion& motion) {
  HANDGRAFT_REQUIRE(thin.keys.size() == motion.tracks.size());
  for (std::size_t t = 0; t < thin.keys.size(); ++t) {
    const std::vector<PatchKey>& from = thin.motion.tracks[t].keys;
    const std::vector<int>& kept = thin.keys[t];
    std::vector<PatchKey>& keys = motion.tracks[t].keys;
    for (std::size_t i = 0; i < keys.size(); ++i) {
      const auto distance = [&](int key) {
        return std::abs(keys[static_cast<std::size_t>(key)].frame - keys[i].frame);
      };
      const auto nearest = std::min_element(kept.begin(), kept.end(), [&](int a, int b) {
        return distance(a) < distance(b);
      });
      const auto& placement = from[static_cast<std::size_t>(nearest - kept.begin())].placement;
      if (placement) keys[i].placement = placement;
    }
  }
}

std::vector<hand::HandPose> posesBetween(const ThinnedMotion& thin,
                                         const std::vector<hand::HandPose>& poses,
                                         const Motion& motion) {
  HANDGRAFT_REQUIRE(poses.size() == thin.frames.size() && !poses.empty());
  std::vector<hand::HandPose> all = {poses.front()};
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const auto first = static_cast<std::size_t>(thin.frames[i - 1]);
    const auto last = static_cast<std::size_t>(thin.frames[i]);
    const double whole_s = motion.time_s[last] - motion.time_s[first];
    for (std::size_t k = first + 1; k < last; ++k) {
      all.push_back(poseBetween(poses[i - 1], poses[i],
                                (motion.time_s[k] - motion.time_s[first]) / whole_s));
    }
    all.push_back(poses[i]);
  }
  return all;
}

}  // namespace handgraft::manipulation
