#include "core/manipulation/contact_tracker.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/base/error.h"
#include "core/geometry/signed_distance.h"
#include "core/hand/grip_point.h"
#include "core/manipulation/joint_noise.h"
#include "core/manipulation/recorded_frames.h"

namespace handgraft::manipulation {

namespace {

constexpr double kMovedTouch = 0.001;    // m
constexpr double kNoNoise = 4.0;         // times its standard deviation
constexpr double kShortestTouch = 0.04;  // s
constexpr double kPalmFlesh = 0.015;     // m
constexpr double kToldNoise = 0.0005;    // m

struct Part {
  int digit = -1;       // 0 thumb to 4 little; -1: the palm
  int segment = 0;      // 0 proximal to 2 distal
  double along = 0.5;   // of the segment, or from the knuckles to the wrist
  double across = 0.5;  // of the palm
  double flesh_m = 0.0;
  std::string name;
};

constexpr std::array<const char*, 5> kDigitNames{"thumb", "index", "middle", "ring", "little"};
constexpr std::array<const char*, 3> kSegmentNames{"proximal", "middle", "distal"};

// Half a mean hand's thickness, at the middle of each segment and at the tip.
constexpr std::array<double, 4> kThumbFlesh{0.013, 0.011, 0.010, 0.008};   // m
constexpr std::array<double, 4> kFingerFlesh{0.010, 0.009, 0.008, 0.007};  // m

std::vector<Part> makeParts() {
  std::vector<Part> parts;
  for (int digit = 0; digit < 5; ++digit) {
    const auto& flesh_m = digit == 0 ? kThumbFlesh : kFingerFlesh;
    const std::string name = kDigitNames[static_cast<std::size_t>(digit)];
    for (int segment = 0; segment < 3; ++segment) {
      const auto at = static_cast<std::size_t>(segment);
      parts.push_back(
          {digit, segment, 0.5, 0.5, flesh_m[at], hand::partName(name, kSegmentNames[at])});
    }
    parts.push_back({digit, 2, 0.9, 0.5, flesh_m[3], name + "_tip"});
  }
  parts.push_back({-1, 0, 0.1, 0.2, kPalmFlesh, "palm_1"});
  parts.push_back({-1, 0, 0.1, 0.8, kPalmFlesh, "palm_2"});
  parts.push_back({-1, 0, 0.75, 0.6, kPalmFlesh, "palm_3"});
  return parts;
}

const std::vector<Part>& touchParts() {
  static const std::vector<Part> all_parts = makeParts();
  return all_parts;
}

/// A hand's joints about which places are told.
struct Frame {
  explicit Frame(const DemonstratedFrame& frame)
      : joints_O(frame.X_WO.inverse() * frame.joints_W.colwise().homogeneous()),
        thumbward_O((joints_O.col(5) - joints_O.col(17)).normalized()),
        palmar_sign(frame.side == hand::HandSide::kRight ? 1.0 : -1.0) {}

  hand::JointPlaces joints_O;
  Eigen::Vector3d thumbward_O;  // along the row of knuckles
  double palmar_sign;

  [[nodiscard]] Eigen::Vector3d middleOf(const Part& part) const {
    if (part.digit < 0) {
      const Eigen::Vector3d knuckle =
          (1.0 - part.across) * joints_O.col(5) + part.across * joints_O.col(17);
      return (1.0 - part.along) * knuckle + part.along * joints_O.col(0);
    }
    const int base = 1 + 4 * part.digit + part.segment;
    return (1.0 - part.along) * joints_O.col(base) + part.along * joints_O.col(base + 1);
  }

  [[nodiscard]] Eigen::Vector3d boneOf(int digit, int segment) const {
    const int base = 1 + 4 * digit + segment;
    return (joints_O.col(base + 1) - joints_O.col(base)).normalized();
  }

  /// Fingers bend about the row of knuckles: palmar turns with the bone.
  [[nodiscard]] Eigen::Vector3d sideOf(const Eigen::Vector3d& bone) const {
    return (thumbward_O - thumbward_O.dot(bone) * bone).normalized();
  }

  /// Where on the part the touch lies that is towards p_O. Its bone may be measured on the
  /// object's surface, or inside: so a place in the object, beyond the bone.
  [[nodiscard]] hand::HandLocation placeOf(const Part& part, const Eigen::Vector3d& p_O) const {
    hand::HandLocation place;
    place.along = part.along;
    if (part.digit < 0) {
      place.digit = hand::kPalmPart;
      place.across = part.across;
      return place;
    }
    place.digit = kDigitNames[static_cast<std::size_t>(part.digit)];
    place.segment = kSegmentNames[static_cast<std::size_t>(part.segment)];
    place.segment_count = 3;
    if (part.digit == 0) return place;
    const Eigen::Vector3d bone = boneOf(part.digit, part.segment);
    const Eigen::Vector3d side = sideOf(bone);
    const Eigen::Vector3d palmar = palmar_sign * side.cross(bone);
    const Eigen::Vector3d out = p_O - middleOf(part);
    if (side.allFinite() && palmar.allFinite())
      place.around_rad = std::atan2(out.dot(side), out.dot(palmar));
    return place;
  }
};

void requireFinite(const DemonstratedFrame& frame) {
  if (!frame.joints_W.allFinite())
    rejectInput("frame at {} s: a joint's place is not finite", frame.time_s);
  if (!frame.X_WO.matrix().allFinite())
    rejectInput("frame at {} s: the object's pose is not finite", frame.time_s);
}

/// Tracks of a demonstration's touches, made frame by frame.
class TouchTracks {
 public:
  /// `moved_m`: from where its last key lies a touch has moved on by that.
  TouchTracks(const geometry::TriangleMesh& object_O, std::size_t frames, double moved_m)
      : object_O_(object_O),
        moved_m_(moved_m),
        frames_(static_cast<int>(frames)),
        open_(touchParts().size()),
        last_O_(touchParts().size()) {}

  void append(const DemonstratedFrame& frame, const std::vector<DetectedContact>& touches) {
    const auto k = static_cast<int>(motion_.time_s.size());
    motion_.time_s.push_back(frame.time_s);
    motion_.X_WO.push_back(frame.X_WO);
    if (isDemonstratorDue(motion_, k)) {
      if (const std::optional<Pose> X_OD = palmOf(frame))
        motion_.demonstrator.push_back({k, *X_OD, postureOf(frame)});
    }
    std::vector<char> is_touching(open_.size(), 0);
    for (const DetectedContact& touch : touches) {
      is_touching[static_cast<std::size_t>(touch.part)] = 1;
      follow(touch, k);
    }
    for (std::size_t part = 0; part < open_.size(); ++part)
      if (open_[part] && is_touching[part] == 0) close(part, k);
  }

  /// Ends what still touches. By rising begin; says what was left out.
  Motion finish() && {
    for (std::size_t part = 0; part < open_.size(); ++part)
      if (open_[part]) close(part, frames_);
    std::stable_sort(motion_.tracks.begin(), motion_.tracks.end(),
                     [](const PatchTrack& a, const PatchTrack& b) {
                       return a.begin() < b.begin();
                     });
    if (fleeting_ > 0)
      motion_.notes.push_back(fmt::format("left out {} touches that last less than {:.0f} ms",
                                          fleeting_, 1e3 * kShortestTouch));
    return std::move(motion_);
  }

 private:
  /// A key where a touch begins, and one wherever it has moved on.
  void follow(const DetectedContact& touch, int k) {
    const auto part = static_cast<std::size_t>(touch.part);
    const std::string& name = touchParts()[part].name;
    const Eigen::Vector3d p_O = positionOf(object_O_, touch.point_O);
    std::optional<PatchTrack>& track = open_[part];
    if (track && (p_O - last_O_[part]).norm() < moved_m_) return;
    if (!track) track.emplace().name = name;
    PatchKey key;
    key.frame = k;
    key.patch.name = name;
    key.patch.root = touch.point_O;
    key.patch.interpolation_boundary = {touch.point_O};
    key.patch.place = touch.place;
    track->keys.push_back(std::move(key));
    last_O_[part] = p_O;
  }

  void close(std::size_t part, int end) {
    PatchTrack track = *std::exchange(open_[part], std::nullopt);
    track.end = end;
    const double lasted_s = motion_.time_s[static_cast<std::size_t>(end - 1)] -
                            motion_.time_s[static_cast<std::size_t>(track.begin())];
    if (lasted_s < kShortestTouch && track.begin() > 0 && end < frames_) {
      ++fleeting_;
    } else {
      motion_.tracks.push_back(std::move(track));
    }
  }

  const geometry::TriangleMesh& object_O_;
  double moved_m_;
  int frames_;
  Motion motion_;
  std::vector<std::optional<PatchTrack>> open_;  // by part: the touch that lasts
  std::vector<Eigen::Vector3d> last_O_;          // by part: where its last key lies
  int fleeting_ = 0;
};

[[noreturn]] void rejectUntouched(const std::vector<DemonstratedFrame>& frames,
                                  const geometry::TriangleMesh& object_O) {
  double nearest = std::numeric_limits<double>::infinity();
  const geometry::SurfaceLocator locator(object_O);
  for (const DemonstratedFrame& frame : frames) {
    const hand::JointPlaces joints_O = Frame(frame).joints_O;
    for (int joint = 0; joint < joints_O.cols(); ++joint)
      nearest = std::min(nearest, locator.nearest(joints_O.col(joint)).distance);
  }
  constexpr double kInNoRoom = 10.0;  // m
  rejectInput("the hand touches nothing: its joints come no nearer than {:.1f} mm{}",
              1e3 * nearest,
              nearest > kInNoRoom ? ": are hand and object both in metres?" : "");
}

/// That joints lie where no flesh lets them: another object, or another pose of it. Empty: no
/// joint does.
std::string noteOfDepth(const std::vector<DemonstratedFrame>& frames,
                        const geometry::TriangleMesh& object_O) {
  const std::vector<double> depths = depthsOfJoints(frames, object_O);
  const double deepest = *std::max_element(depths.begin(), depths.end());
  if (deepest <= kImpossibleDepth) return "";
  return fmt::format(
      "joints lie up to {:.0f} mm inside the object, in {} of {} frames more than {:.0f}: is "
      "it "
      "that object, in that pose (x y z qw qx qy qz)?",
      1e3 * deepest,
      std::count_if(depths.begin(), depths.end(),
                    [](double depth) {
                      return depth > kImpossibleDepth;
                    }),
      frames.size(), 1e3 * kImpossibleDepth);
}

}  // namespace

ContactTracker::ContactTracker(const geometry::TriangleMesh& object_O)
    : object_O_(object_O),
      locator_(object_O),
      is_solid_(object_O.isClosed()),
      touches_(touchParts().size(), 0) {}

const std::vector<std::string>& ContactTracker::partNames() {
  static const std::vector<std::string> part_names = [] {
    std::vector<std::string> names;
    for (const Part& part : touchParts())
      names.push_back(part.name);
    return names;
  }();
  return part_names;
}

std::vector<DetectedContact> ContactTracker::see(const DemonstratedFrame& frame) {
  requireFinite(frame);
  const Frame joints(frame);
  std::vector<DetectedContact> touches;
  for (std::size_t i = 0; i < touches_.size(); ++i) {
    const Part& part = touchParts()[i];
    const auto hit = locator_.nearest(joints.middleOf(part));
    const double reach = part.flesh_m + (touches_[i] != 0 ? kEnd : kBegin);
    touches_[i] = hit.distance <= reach ? 1 : 0;
    if (touches_[i] == 0) continue;
    const Eigen::Vector3d p_O = positionOf(object_O_, hit.point);
    // Which side of a sheet is out, nobody knows.
    const Eigen::Vector3d beyond_O =
        is_solid_ ? p_O - 2.0 * part.flesh_m * normalOf(object_O_, hit.point) : p_O;
    touches.push_back({static_cast<int>(i), joints.placeOf(part, beyond_O), hit.point});
  }
  return touches;
}

std::vector<contact::PartDirection> postureOf(const DemonstratedFrame& frame) {
  const Frame joints(frame);
  std::vector<contact::PartDirection> posture;
  const auto add = [&](const std::string& name, const Eigen::Vector3d& bone, bool has_palmar) {
    contact::PartDirection part{name, bone, Eigen::Vector3d::Zero()};
    if (has_palmar) part.palmar_O = joints.palmar_sign * joints.sideOf(bone).cross(bone);
    if (part.outward_O.allFinite() && part.palmar_O.allFinite())
      posture.push_back(std::move(part));
  };
  for (int digit = 0; digit < 5; ++digit) {
    for (int segment = 0; segment < 3; ++segment) {
      add(hand::partName(kDigitNames[static_cast<std::size_t>(digit)],
                         kSegmentNames[static_cast<std::size_t>(segment)]),
          joints.boneOf(digit, segment), digit > 0);
    }
  }
  constexpr int kMiddleKnuckle = 9;
  add(hand::kPalmPart,
      (joints.joints_O.col(kMiddleKnuckle) - joints.joints_O.col(0)).normalized(), true);
  return posture;
}

std::vector<double> depthsOfJoints(const std::vector<DemonstratedFrame>& frames,
                                   const geometry::TriangleMesh& object_O) {
  const geometry::SignedDistance distance_O(object_O, geometry::Holes::kOpenWideOnes);
  std::vector<double> depths;
  for (const DemonstratedFrame& frame : frames) {
    const hand::JointPlaces joints_O = Frame(frame).joints_O;
    double depth = 0.0;
    for (int joint = 0; joint < joints_O.cols(); ++joint)
      depth = std::max(depth, -distance_O.at(joints_O.col(joint)).distance);
    depths.push_back(depth);
  }
  return depths;
}

std::optional<Pose> palmOf(const DemonstratedFrame& frame) {
  constexpr int kMiddleKnuckle = 9;
  const Frame joints(frame);
  const Eigen::Vector3d along =
      (joints.joints_O.col(kMiddleKnuckle) - joints.joints_O.col(0)).normalized();
  const Eigen::Vector3d side = joints.sideOf(along);
  Pose X_OD = Pose::Identity();
  X_OD.linear() << along, side, along.cross(side);
  X_OD.translation() = joints.joints_O.col(0);
  if (!(std::abs(X_OD.linear().determinant() - 1.0) < 1e-6)) return std::nullopt;
  return X_OD;
}

ShownHand shownBy(const DemonstratedFrame& frame) {
  return {postureOf(frame), palmOf(frame), hand::gripPointOf(Frame(frame).joints_O)};
}

Motion motionOfDemonstration(const std::vector<DemonstratedFrame>& frames,
                             const geometry::TriangleMesh& object_O) {
  if (frames.empty()) rejectInput("a demonstration without frames is no motion");
  if (frames.size() > static_cast<std::size_t>(kMostFrames))
    rejectInput("{} frames are more than the {} permitted", frames.size(), kMostFrames);
  for (std::size_t k = 0; k < frames.size(); ++k) {
    const double time_s = frames[k].time_s;
    if (!std::isfinite(time_s) || (k > 0 && time_s <= frames[k - 1].time_s))
      rejectInput("frame {}: its time {} s does not lie behind the one before", k, time_s);
  }
  const RecordedFrames recorded = withoutGlitches(frames);
  for (const DemonstratedFrame& frame : recorded.frames)
    requireFinite(frame);
  const double noise_m = jointNoise(recorded.frames);
  ContactTracker tracker(object_O);
  const EvenedFrames even = evenedOut(recorded.frames, noise_m);
  // What noise leaves moves no touch.
  TouchTracks tracks(object_O, even.frames.size(),
                     std::max(kMovedTouch, kNoNoise * even.noise_m));
  for (const DemonstratedFrame& frame : even.frames)
    tracks.append(frame, tracker.see(frame));
  Motion motion = std::move(tracks).finish();
  motion.notes.insert(motion.notes.begin(), recorded.notes.begin(), recorded.notes.end());
  if (noise_m > kToldNoise)
    motion.notes.push_back(
        fmt::format("joints are measured with some {:.1f} mm of noise, which is evened out",
                    1e3 * noise_m));
  if (motion.tracks.empty()) rejectUntouched(recorded.frames, object_O);
  if (std::string note = noteOfDepth(even.frames, object_O); !note.empty())
    motion.notes.push_back(std::move(note));
  motion.side = frames.front().side == hand::HandSide::kLeft ? hand::Chirality::kLeft
                                                             : hand::Chirality::kRight;
  validate(object_O, motion);
  return motion;
}

}  // namespace handgraft::manipulation
