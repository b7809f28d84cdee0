#include "core/manipulation/motion.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <set>

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/base/time_note.h"
#include "core/hand/hand_location.h"
#include "core/manipulation/trajectory.h"

namespace handgraft::manipulation {

namespace {

// A rotation's columns as files round them.
constexpr double kRotationTolerance = 1e-6;

void requireTimes(const Motion& motion) {
  if (motion.time_s.empty())
    rejectInput("motion has 0 frames; permitted are 1 to {}", kMostFrames);
  if (motion.time_s.size() > static_cast<std::size_t>(kMostFrames))
    rejectInput("motion has {} frames; permitted are 1 to {}", motion.time_s.size(),
                kMostFrames);
  for (std::size_t k = 0; k < motion.time_s.size(); ++k) {
    if (!std::isfinite(motion.time_s[k]))
      rejectInput("frame {}: time is {} s; it must be finite", k, motion.time_s[k]);
    if (k > 0 && !(motion.time_s[k] > motion.time_s[k - 1])) {
      rejectInput("frame {}: time {} s does not lie behind the frame before it, {} s", k,
                  motion.time_s[k], motion.time_s[k - 1]);
    }
  }
}

void requireProper(const Pose& X, const std::string& what) {
  if (!X.matrix().allFinite()) rejectInput("{} is not finite", what);
  const Eigen::Matrix3d R = X.linear();
  if ((R * R.transpose() - Eigen::Matrix3d::Identity()).norm() > kRotationTolerance ||
      R.determinant() < 0.0)
    rejectInput("{} is no rotation and translation", what);
}

bool isUnit(const Eigen::Vector3d& d) {
  constexpr double kRounded = 1e-3;  // as files write them
  return std::abs(d.norm() - 1.0) < kRounded;
}

void requirePoses(const Motion& motion) {
  if (motion.X_WO.size() != motion.time_s.size()) {
    rejectInput("motion has {} poses of its object; {} frames need as many", motion.X_WO.size(),
                motion.time_s.size());
  }
  for (std::size_t k = 0; k < motion.X_WO.size(); ++k)
    requireProper(motion.X_WO[k], fmt::format("frame {}: the object's pose", k));
}

void requireDemonstrator(const Motion& motion) {
  int before = -1;
  std::size_t parts = 0;
  for (const DemonstratorKey& key : motion.demonstrator) {
    if (key.frame <= before || key.frame >= motion.frameCount()) {
      rejectInput("demonstrator: key at frame {}; permitted are {} to {}", key.frame,
                  before + 1, motion.frameCount() - 1);
    }
    before = key.frame;
    requireProper(key.X_OD, fmt::format("demonstrator, frame {}: the hand's pose", key.frame));
    if (key.posture.size() > contact::kMostParts)
      rejectInput("demonstrator, frame {}: a posture of {} parts; permitted are {}", key.frame,
                  key.posture.size(), contact::kMostParts);
    parts += key.posture.size();
    for (const contact::PartDirection& part : key.posture) {
      const bool has_palmar = !part.palmar_O.isZero();
      if (!isUnit(part.outward_O) || (has_palmar && !isUnit(part.palmar_O)))
        rejectInput("demonstrator, frame {}: a direction of part {} is not of unit length",
                    key.frame, quoted(part.part));
    }
  }
  if (parts > kMostMotionParts)
    rejectInput("demonstrator: postures of {} parts in all; permitted are {}", parts,
                kMostMotionParts);
}

void requirePlaces(const geometry::TriangleMesh& object_O, const PatchKey& key) {
  const contact::Patch& patch = key.patch;
  geometry::validate(object_O, patch.root, "root");
  if (patch.interpolation_boundary.empty()) rejectInput("has 0 points; 1 at least is needed");
  for (const geometry::SurfacePoint& point : patch.interpolation_boundary)
    geometry::validate(object_O, point, "point");
  if (patch.direction_O && !patch.direction_O->allFinite())
    rejectInput("direction is not finite");
  if (!(patch.weight >= 0.0) || patch.weight > contact::kLargestWeight)
    rejectInput("weight is {}; permitted are 0 to {}", patch.weight, contact::kLargestWeight);
  if (!key.hand_points.empty() &&
      key.hand_points.size() != patch.interpolation_boundary.size()) {
    rejectInput("has {} points on the hand; its {} points need as many or none",
                key.hand_points.size(), patch.interpolation_boundary.size());
  }
  for (const HandPoint& point : key.hand_points)
    if (!point.p_L.allFinite()) rejectInput("a point on link '{}' is not finite", point.link);
}

void requireTrack(const geometry::TriangleMesh& object_O,
                  const PatchTrack& track,
                  int frame_count) {
  if (track.keys.empty()) rejectInput("has 0 keys; 1 at least is needed");
  int before = -1;
  for (const PatchKey& key : track.keys) {
    if (key.frame <= before || key.frame >= frame_count) {
      rejectInput("key at frame {}; permitted are {} to {}", key.frame, before + 1,
                  frame_count - 1);
    }
    before = key.frame;
    try {
      requirePlaces(object_O, key);
    } catch (const InvalidInput& error) {
      rejectInput("key at frame {}: {}", key.frame, error.what());
    }
  }
  if (track.end <= before || track.end > frame_count)
    rejectInput("ends at frame {}; permitted are {} to {}", track.end, before + 1, frame_count);
}

}  // namespace

bool isRecorded(const PatchKey& key) {
  return key.patch.interpolation_boundary.size() <
         static_cast<std::size_t>(contact::kFewestInterpolationPoints);
}

const PatchKey& PatchTrack::keyAt(int frame) const {
  HANDGRAFT_REQUIRE(!keys.empty() && frame >= begin() && frame < end);
  const auto behind =
      std::upper_bound(keys.begin(), keys.end(), frame, [](int at, const PatchKey& key) {
        return at < key.frame;
      });
  return *(behind - 1);
}

int strideOf(const std::vector<double>& time_s, double seconds) {
  const auto steps = static_cast<int>(time_s.size()) - 1;
  if (steps < 1) return 1;
  const double step_s = (time_s.back() - time_s.front()) / steps;
  return static_cast<int>(std::clamp(std::round(seconds / step_s), 1.0, double(steps)));
}

const DemonstratorKey& demonstratorNear(const Motion& motion, int frame) {
  const std::vector<DemonstratorKey>& keys = motion.demonstrator;
  HANDGRAFT_REQUIRE(!keys.empty());
  return *std::min_element(keys.begin(), keys.end(), [&](const auto& a, const auto& b) {
    return std::abs(a.frame - frame) < std::abs(b.frame - frame);
  });
}

Pose demonstratorPoseAt(const Motion& motion, int frame) {
  const std::vector<DemonstratorKey>& keys = motion.demonstrator;
  HANDGRAFT_REQUIRE(!keys.empty());
  const auto behind = std::upper_bound(keys.begin(), keys.end(), frame,
                                       [](int wanted, const DemonstratorKey& key) {
                                         return wanted < key.frame;
                                       });
  if (behind == keys.begin()) return keys.front().X_OD;
  const DemonstratorKey& before = *(behind - 1);
  if (behind == keys.end()) return before.X_OD;
  const auto time_of = [&](int k) {
    return motion.time_s.at(static_cast<std::size_t>(k));
  };
  const double share = (time_of(frame) - time_of(before.frame)) /
                       (time_of(behind->frame) - time_of(before.frame));
  return poseBetween({before.X_OD, {}}, {behind->X_OD, {}}, share).X_WH;
}

bool isDemonstratorDue(const Motion& motion, int frame) {
  constexpr double kHalfStep = 0.5e-6;  // s; for sums of steps
  const auto time_at = [&](int k) {
    return motion.time_s.at(static_cast<std::size_t>(k));
  };
  return motion.demonstrator.empty() ||
         time_at(frame) - time_at(motion.demonstrator.back().frame) >=
             kDemonstratorEvery - kHalfStep;
}

void validate(const geometry::TriangleMesh& object_O, const Motion& motion) {
  requireTimes(motion);
  requirePoses(motion);
  requireDemonstrator(motion);
  std::size_t keys = 0;
  std::size_t points = 0;
  for (std::size_t i = 0; i < motion.tracks.size(); ++i) {
    const PatchTrack& track = motion.tracks[i];
    try {
      requireTrack(object_O, track, motion.frameCount());
    } catch (const InvalidInput& error) {
      rejectInput("track {} ({}): {}", i, quoted(track.name), error.what());
    }
    if (i > 0 && track.begin() < motion.tracks[i - 1].begin()) {
      rejectInput("track {} ({}) begins at frame {}, before the one listed before it, {}", i,
                  quoted(track.name), track.begin(), motion.tracks[i - 1].begin());
    }
    keys += track.keys.size();
    for (const PatchKey& key : track.keys)
      points += key.patch.interpolation_boundary.size();
  }
  if (keys > kMostKeys) rejectInput("motion has {} keys; permitted are {}", keys, kMostKeys);
  if (points > kMostMotionPoints)
    rejectInput("motion has {} points; permitted are {}", points, kMostMotionPoints);
}

namespace {

/// c1, c2, ...
bool isNumbered(const std::string& name) {
  return name.size() > 1 && name[0] == 'c' &&
         name.find_first_not_of("0123456789", 1) == std::string::npos;
}

/// Whether a track of recorded points has a name that says nothing to a session.
bool isForeign(const PatchTrack& track) {
  const PatchKey& first = track.keys.front();
  if (!isRecorded(first)) return false;
  if (!first.hand_points.empty() && first.hand_points.front().link == track.name) return true;
  return !first.patch.place && !hand::placeNamed(track.name) && !isNumbered(track.name);
}

}  // namespace

void nameByParts(Motion& motion) {
  std::set<std::string> taken;
  for (const PatchTrack& track : motion.tracks)
    taken.insert(track.name);
  std::map<std::string, std::string> named;
  std::map<std::string, int> counts;  // of names that were tried, by part
  for (PatchTrack& track : motion.tracks) {
    if (!isForeign(track)) continue;
    const auto [known, is_new] = named.try_emplace(track.name);
    if (is_new) {
      const std::optional<hand::HandLocation>& place = track.keys.front().patch.place;
      const std::string part = place ? hand::partName(place->digit, place->segment) : "";
      int& count = counts[part];
      do {
        ++count;
        known->second = !place       ? fmt::format("c{}", count)
                        : count == 1 ? part
                                     : fmt::format("{}_{}", part, count);
      } while (!taken.insert(known->second).second);
    }
    track.name = known->second;
    for (PatchKey& key : track.keys)
      key.patch.name = track.name;
  }
}

std::vector<std::string> remarksOn(const Motion& motion, bool is_causal) {
  std::vector<std::string> remarks;
  if (std::string note = timeUnitNote(motion.time_s); !note.empty())
    remarks.push_back(std::move(note));
  int jumps = 0;
  int first_jump = 0;
  for (std::size_t k = 1; k < motion.X_WO.size(); ++k) {
    const Pose step = motion.X_WO[k] * inverse(motion.X_WO[k - 1]);
    const double way = (motion.X_WO[k].translation() - motion.X_WO[k - 1].translation()).norm();
    if (way <= kJumpWay && vectorFromRotation(step.linear()).norm() <= kJumpTurn) continue;
    if (jumps == 0) first_jump = static_cast<int>(k);
    ++jumps;
  }
  if (jumps > 0) {
    remarks.push_back(fmt::format(
        "the object jumps {} time{}, first to frame {} at {:.3f} s; the hand goes along", jumps,
        jumps == 1 ? "" : "s", first_jump,
        motion.time_s[static_cast<std::size_t>(first_jump)]));
  }
  std::vector<char> touched(motion.time_s.size(), 0);
  for (const PatchTrack& track : motion.tracks)
    std::fill(touched.begin() + track.begin(), touched.begin() + track.end, 1);
  const auto bare = std::count(touched.begin(), touched.end(), 0);
  if (bare > 0) {
    remarks.push_back(fmt::format(
        "{} of {} frames have no contact; the hand {}", bare, touched.size(),
        is_causal || motion.demonstrator.empty() ? "follows the object"
                                                 : "goes as the demonstrator's does"));
  }
  return remarks;
}

}  // namespace handgraft::manipulation
