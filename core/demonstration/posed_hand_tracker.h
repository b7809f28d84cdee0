#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/geometry/solid.h"
#include "core/geometry/surface_locator.h"
#include "core/hand/grip_point.h"
#include "core/hand/hand.h"
#include "core/hand/hand_solid.h"
#include "core/hand/kinematics.h"
#include "core/hand/turned_parts.h"
#include "core/manipulation/contact_tracker.h"

namespace handgraft::demonstration {

/// Finds which parts of a hand whose pose is known touch an object, frame by frame: segments of
/// its digits, their tips, and three parts of its palm, by the links' own surfaces. The
/// counterpart of manipulation::ContactTracker, which knows a human hand's joints alone.
///
/// A part touches once its surface is within kBegin of the object, and until it is farther than
/// kEnd: half of ContactTracker's, which has to guess the flesh. Its place is the middle of
/// what is nearest, so that a flat pad on a flat face does not flicker between its samples.
///
/// Deterministic. Cost: some 0.1 ms a frame.
class PosedHandTracker {
 public:
  static constexpr double kBegin = 0.003;  // m
  static constexpr double kEnd = 0.006;    // m

  /// Errors: Cancelled on wish. Cost: where each sample lies on the hand, some tens of
  /// milliseconds; solids if they are not there yet.
  PosedHandTracker(const hand::Hand& hand,
                   std::shared_ptr<const geometry::TriangleMesh> object_O,
                   const Progress& progress);

  /// The touches of the next frame, by rising part; parts are numbered by this tracker.
  /// Frames: pose and X_WO in W. Errors: InvalidInput, and nothing changes, if one of them is
  /// not finite; BrokenContract on a pose of another hand.
  std::vector<manipulation::DetectedContact> see(const hand::HandPose& pose, const Pose& X_WO);

  /// How the hand's segments and its palm are turned.
  [[nodiscard]] std::vector<contact::PartDirection> postureOf(const hand::HandPose& pose,
                                                              const Pose& X_WO) const;

  [[nodiscard]] manipulation::ShownHand shownBy(const hand::HandPose& pose,
                                                const Pose& X_WO) const;

  /// By part: `index_distal`, `index_tip`, `palm_1`, as manipulation::ContactTracker's.
  [[nodiscard]] const std::vector<std::string>& partNames() const { return part_names_; }

 private:
  /// A sample of a link's surface, by its place on the hand.
  struct Spot {
    int part = -1;  ///< -1: of no digit, nor of the palm
    hand::HandLocation place;
  };

  /// A sample that may touch.
  struct Near {
    int part = -1;
    const Spot* spot = nullptr;
    Eigen::Vector3d p_O;
    double distance = 0.0;
    double area_m2 = 0.0;
  };

  [[nodiscard]] std::vector<Near> nearSamples(const hand::LinkPoses& X_OL) const;
  [[nodiscard]] manipulation::DetectedContact middleOf(const std::vector<Near>& near,
                                                       double& distance) const;

  hand::Hand hand_;
  std::shared_ptr<const geometry::TriangleMesh> object_O_;
  std::shared_ptr<const hand::HandSolid> solid_;
  std::shared_ptr<const geometry::Solid> object_solid_O_;
  geometry::SurfaceLocator locator_;
  std::vector<std::vector<Spot>> spots_;  ///< of each of the solid's links' fine samples
  std::vector<hand::TurnedPart> turned_;
  hand::GripPoint grip_;
  std::vector<std::string> part_names_;
  std::vector<char> touches_;  ///< by part
};

}  // namespace handgraft::demonstration
