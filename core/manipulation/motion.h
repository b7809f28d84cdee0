#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/base/pose.h"
#include "core/contact/contact_set.h"
#include "core/contact/patch.h"
#include "core/geometry/triangle_mesh.h"
#include "core/hand/digits.h"
#include "core/transfer/patch_placement.h"

namespace handgraft::manipulation {

/// Where a point of a patch is on a hand of which the motion knows, in a link of it.
struct HandPoint {
  std::string link;
  Eigen::Vector3d p_L = Eigen::Vector3d::Zero();
};

/// A patch from a frame on, until its next key.
struct PatchKey {
  int frame = 0;
  /// On the object's mesh. Recorded points may be fewer than an outline has: one at least.
  contact::Patch patch;
  /// Of each point of the interpolation boundary, where a recording gives them (its `hand`);
  /// empty: the patch is laid onto the skin by its name and its place.
  std::vector<HandPoint> hand_points;
  /// On the skin of the hand that follows, where that has been found: then the patch is laid
  /// there. No file has it.
  std::optional<transfer::PatchPlacement> placement;
};

/// A recorded point, without an outline.
bool isRecorded(const PatchKey& key);

/// A patch from where it appears to where it vanishes. One that comes back is another track,
/// which may have the same name.
struct PatchTrack {
  std::string name;
  int end = 0;                 ///< the first frame without it
  std::vector<PatchKey> keys;  ///< by rising frame; the first one is where it appears
  /// Why it is not asked of the hand that follows; empty: it is. No file has it.
  std::string dropped;

  [[nodiscard]] int begin() const { return keys.front().frame; }

  /// The key that holds at `frame`, begin() <= frame < end.
  [[nodiscard]] const PatchKey& keyAt(int frame) const;
};

/// The demonstrator's hand at a frame, touching or not.
struct DemonstratorKey {
  int frame = 0;
  Pose X_OD = Pose::Identity();  ///< of any frame fixed to its palm: only its way counts
  std::vector<contact::PartDirection> posture;
};

/// So many frames of a motion take so long, on average; one at least. Cost: O(1).
int strideOf(const std::vector<double>& time_s, double seconds);

/// Contacts and object over time: what a hand did, as far as another hand can do the same.
struct Motion {
  std::string name;
  std::string object;  ///< what it is called; empty where the source does not say
  hand::Chirality side = hand::Chirality::kUnknown;  ///< of the hand that touched, if told
  std::string hand;                ///< whose `hand_points` the keys have; empty: nobody's
  std::vector<double> time_s;      ///< of each frame, rising
  std::vector<Pose> X_WO;          ///< of each frame
  std::vector<PatchTrack> tracks;  ///< by rising begin
  /// By rising frame, some each kDemonstratorEvery; between two of them the hand is in between.
  /// Empty: nobody knows.
  std::vector<DemonstratorKey> demonstrator;
  /// Remarks of whoever made it, shown to the user.
  std::vector<std::string> notes;

  [[nodiscard]] int frameCount() const { return static_cast<int>(time_s.size()); }

  [[nodiscard]] double duration() const { return time_s.back() - time_s.front(); }
};

/// A person's hand changes little in that.
inline constexpr double kDemonstratorEvery = 0.04;  // s

/// The key nearest to a frame. BrokenContract, as below, if nobody knows the demonstrator.
const DemonstratorKey& demonstratorNear(const Motion& motion, int frame);

/// X_OD at any frame: in between from key to key, before the first and behind the last as
/// there.
Pose demonstratorPoseAt(const Motion& motion, int frame);

/// Whether a frame is due for a key of the demonstrator's hand: the first, and so much later
/// than the last key's.
bool isDemonstratorDue(const Motion& motion, int frame);

// Bounds of memory: what a file asks for must not grow without end.
inline constexpr int kMostFrames = 1'000'000;
inline constexpr std::size_t kMostKeys = 4'000'000;
inline constexpr std::size_t kMostMotionPoints = 20'000'000;
inline constexpr std::size_t kMostMotionParts = 4'000'000;  ///< of all postures

/// Everything a motion promises: frames, times that rise and are finite, proper poses, tracks
/// within the frames, keys that rise, patches on the mesh, directions of unit length.
/// InvalidInput names the frame or the
/// track, the value and what is permitted.
void validate(const geometry::TriangleMesh& object_O, const Motion& motion);

/// Recordings name points by links of their own hand, which say nothing of another one: such
/// tracks get the name of the part they are on (index_distal, palm), with a number behind where
/// it is several links', or c1, c2, ... where nobody knows the part. Others keep theirs.
void nameByParts(Motion& motion);

/// What a user should know of it though nothing is wrong: an object that jumps from one frame
/// to the next (more than kJumpWay or kJumpTurn), gaps in time, times that seem to be
/// milliseconds, frames without any contact.
/// `is_causal`: it is solved frame by frame, and nobody is followed where nothing touches.
std::vector<std::string> remarksOn(const Motion& motion, bool is_causal = false);

inline constexpr double kJumpWay = 0.1;   // m
inline constexpr double kJumpTurn = 0.5;  // rad

}  // namespace handgraft::manipulation
