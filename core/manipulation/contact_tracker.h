#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/base/pose.h"
#include "core/contact/contact_set.h"
#include "core/geometry/surface_locator.h"
#include "core/geometry/triangle_mesh.h"
#include "core/hand/demonstrated_joints.h"
#include "core/hand/hand_location.h"
#include "core/manipulation/motion.h"

namespace handgraft::manipulation {

/// What a demonstrator does at a time.
struct DemonstratedFrame {
  double time_s = 0.0;
  hand::HandSide side = hand::HandSide::kRight;
  hand::JointPlaces joints_W;
  Pose X_WO = Pose::Identity();
};

/// Where a part of the demonstrator's hand touches the object.
struct DetectedContact {
  int part = 0;              ///< index into ContactTracker::partNames
  hand::HandLocation place;  ///< on the demonstrator's hand
  geometry::SurfacePoint point_O;
};

/// Finds which parts of a hand, of which only the joints are known, touch an object, frame by
/// frame: segments of the digits, their tips, and the palm.
///
/// A part touches once the object is within its flesh and `kBegin_m`, and until it is farther
/// than its flesh and `kEnd_m`, so that what is measured with noise does not come and go. Flesh
/// is that of a mean hand. Which way round the digit the object lies is told for all digits
/// but the thumb, which counts as palmar: its joints do not tell where its pad is.
///
/// Deterministic. Cost: one nearest place of the mesh a part and frame.
class ContactTracker {
 public:
  static constexpr double kBegin = 0.006;  // m
  static constexpr double kEnd = 0.012;    // m

  /// Keeps a reference.
  explicit ContactTracker(const geometry::TriangleMesh& object_O);

  /// `index_distal`, `index_tip`, `palm_1`, ...: unique.
  [[nodiscard]] static const std::vector<std::string>& partNames();

  /// The touches of the next frame, by rising part.
  /// Errors: InvalidInput, and nothing changes, if a joint or the object's pose is not finite.
  std::vector<DetectedContact> see(const DemonstratedFrame& frame);

 private:
  const geometry::TriangleMesh& object_O_;
  geometry::SurfaceLocator locator_;
  bool is_solid_;
  std::vector<char> touches_;
};

/// How the segments and the palm of that hand are turned; a thumb's joints do not tell where it
/// closes to.
std::vector<contact::PartDirection> postureOf(const DemonstratedFrame& frame);

/// No flesh lets a joint lie deeper in an object (m); recorded grasps come to 0.012, with noise
/// to 0.017.
inline constexpr double kImpossibleDepth = 0.02;

/// How deep in the object the deepest joint of each frame lies (m); 0 where all are outside.
/// Errors: InvalidInput for what is not finite. Cost: some 0.1 ms a frame.
std::vector<double> depthsOfJoints(const std::vector<DemonstratedFrame>& frames,
                                   const geometry::TriangleMesh& object_O);

/// Where the palm of that hand is, in O: at the wrist, x towards the middle finger's knuckle, y
/// along the row of knuckles towards the index finger. Nothing where these lie in one line.
std::optional<Pose> palmOf(const DemonstratedFrame& frame);

/// How a demonstrator's hand is held over the object, touching or not.
struct ShownHand {
  std::vector<contact::PartDirection> posture;
  std::optional<Pose> X_OD{};               ///< any frame fixed to its palm; nobody knows it
  std::optional<Eigen::Vector3d> grip_O{};  ///< hand::GripPoint; nobody knows it
};

ShownHand shownBy(const DemonstratedFrame& frame);

/// The motion of a demonstration: a track from where a part begins to touch until it ends, a
/// key where the touch has moved by a millimetre, or by what noise of the joints may move it,
/// which is measured, evened out (joint_noise.h), and noted. Glitches of its tracker
/// (recorded_frames.h) and touches that last less than 40 ms are left out, and noted.
/// Errors: InvalidInput for no frames, times that do not rise, what is no hand's
/// (withoutGlitches), and if nothing ever touches: how near it came.
Motion motionOfDemonstration(const std::vector<DemonstratedFrame>& frames,
                             const geometry::TriangleMesh& object_O);

}  // namespace handgraft::manipulation
