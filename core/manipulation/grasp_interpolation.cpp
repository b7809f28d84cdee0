#include "core/manipulation/grasp_interpolation.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/error.h"
#include "core/base/smooth_step.h"
#include "core/manipulation/patch_path.h"

namespace handgraft::manipulation {

namespace {

using contact::ContactSet;
using contact::Patch;

void requireOptions(const TwoGraspOptions& options, const std::vector<ObjectKey>& path) {
  if (path.empty()) rejectInput("the object's path has 0 keys; 1 at least is needed");
  for (std::size_t i = 1; i < path.size(); ++i) {
    if (!(path[i].time_s > path[i - 1].time_s))
      rejectInput(
          "key {} of the object's path: time {} s does not lie behind the one before, {} s", i,
          path[i].time_s, path[i - 1].time_s);
  }
  const double frames = options.rate * (path.back().time_s - path.front().time_s) + 1.0;
  if (!(options.rate > 0.0) || !(frames <= kMostFrames))
    rejectInput("rate {} makes {} frames; permitted are 1 to {}", options.rate, frames,
                kMostFrames);
  const double shares[] = {0.0, options.slide_begin, options.slide_end, 1.0};
  if (!std::is_sorted(std::begin(shares), std::end(shares)))
    rejectInput("patches slide from {} to {}; permitted are shares that rise from 0 to 1",
                options.slide_begin, options.slide_end);
  for (const double share : {options.vanish, options.appear})
    if (!(share > 0.0 && share < 1.0))
      rejectInput("patches vanish at {} and appear at {}; permitted are shares between 0 and 1",
                  options.vanish, options.appear);
}

Pose poseAt(const std::vector<ObjectKey>& path, double time_s) {
  std::size_t behind = 0;
  while (behind < path.size() && path[behind].time_s <= time_s)
    ++behind;
  if (behind == 0) return path.front().X_WO;
  if (behind == path.size()) return path.back().X_WO;
  const ObjectKey& a = path[behind - 1];
  const ObjectKey& b = path[behind];
  const double share = (time_s - a.time_s) / (b.time_s - a.time_s);
  Pose X = a.X_WO;
  const Eigen::Vector3d turn =
      vectorFromRotation(b.X_WO.linear() * a.X_WO.linear().transpose());
  X.linear() = rotationFromVector(share * turn) * a.X_WO.linear();
  X.translation() += share * (b.X_WO.translation() - a.X_WO.translation());
  return X;
}

const Patch* patchNamed(const ContactSet& set, const std::string& name) {
  const auto found =
      std::find_if(set.patches.begin(), set.patches.end(), [&](const Patch& patch) {
        return patch.name == name;
      });
  return found == set.patches.end() ? nullptr : &*found;
}

/// The place on the hand between two on one segment; the nearer one's else.
std::optional<hand::HandLocation> placeBetween(const Patch& from,
                                               const Patch& to,
                                               double share) {
  if (!from.place || !to.place || from.place->digit != to.place->digit ||
      from.place->segment != to.place->segment)
    return share < 0.5 ? from.place : to.place;
  hand::HandLocation place = *from.place;
  const auto mixed = [share](double a, double b) {
    return (1.0 - share) * a + share * b;
  };
  place.along = mixed(from.place->along, to.place->along);
  place.across = mixed(from.place->across, to.place->across);
  place.around_rad += share * std::remainder(to.place->around_rad - from.place->around_rad,
                                             2.0 * std::numbers::pi);
  if (from.place->from_tip >= 0.0 && to.place->from_tip >= 0.0)
    place.from_tip = mixed(from.place->from_tip, to.place->from_tip);
  return place;
}

PatchTrack still(const Patch& patch, int begin, int end) {
  PatchTrack track;
  track.name = patch.name;
  track.end = end;
  track.keys.push_back({begin, patch, {}, {}});
  return track;
}

}  // namespace

Motion interpolateGrasps(const geometry::TriangleMesh& object_O,
                         const ContactSet& first,
                         const ContactSet& last,
                         const std::vector<ObjectKey>& path,
                         const TwoGraspOptions& options) {
  requireOptions(options, path);
  Motion motion;
  motion.name = first.name;
  motion.object = first.object;
  motion.side = first.side;
  const double duration = path.back().time_s - path.front().time_s;
  const int frames = static_cast<int>(std::lround(options.rate * duration)) + 1;
  for (int k = 0; k < frames; ++k) {
    motion.time_s.push_back(path.front().time_s + k / options.rate);
    motion.X_WO.push_back(poseAt(path, motion.time_s.back()));
  }
  const auto frame_at = [frames](double share) {
    return std::clamp(static_cast<int>(std::lround(share * (frames - 1))), 1,
                      std::max(1, frames - 1));
  };
  for (const Patch& patch : first.patches) {
    const Patch* other = patchNamed(last, patch.name);
    if (other == nullptr) {
      motion.tracks.push_back(still(patch, 0, std::min(frames, frame_at(options.vanish))));
      continue;
    }
    const PatchPath way(object_O, patch, *other);
    PatchTrack track = still(way.at(0.0), 0, frames);
    for (int k = 1; k < frames; ++k) {
      const double share =
          std::clamp((static_cast<double>(k) / (frames - 1) - options.slide_begin) /
                         std::max(1e-9, options.slide_end - options.slide_begin),
                     0.0, 1.0);
      if (share == 0.0) continue;
      const double smooth = smoothStep(share);
      Patch moved = way.at(smooth);
      moved.place = placeBetween(patch, *other, smooth);
      track.keys.push_back({k, std::move(moved), {}, {}});
      if (share == 1.0) break;
    }
    motion.tracks.push_back(std::move(track));
  }
  for (const Patch& patch : last.patches)
    if (patchNamed(first, patch.name) == nullptr && frames > 1)
      motion.tracks.push_back(still(patch, frame_at(options.appear), frames));
  std::stable_sort(motion.tracks.begin(), motion.tracks.end(),
                   [](const PatchTrack& a, const PatchTrack& b) {
                     return a.begin() < b.begin();
                   });
  validate(object_O, motion);
  return motion;
}

}  // namespace handgraft::manipulation
