#pragma once

#include <vector>

#include "core/base/progress.h"
#include "core/contact/pose_contacts.h"
#include "core/contact/segmentation.h"
#include "core/geometry/triangle_mesh.h"
#include "core/hand/hand.h"
#include "core/hand/kinematics.h"
#include "core/manipulation/motion.h"

namespace handgraft::demonstration {

/// A hand whose joints are known, and the object, at a time.
struct PosedFrame {
  double time_s = 0.0;
  hand::HandPose pose;  ///< in W
  Pose X_WO = Pose::Identity();
};

struct PosedMotionOptions {
  /// Contacts are cut so often, and hold in between: areas that a hand's skin leaves are no
  /// better known than that.
  double every_s = 0.05;
  contact::PoseContactOptions reach;
  contact::SegmentationOptions segmentation;
};

/// The contact areas of a posed hand over time: what contactsOfPosedHand finds of it every so
/// often, each part of the hand followed from where it begins to touch until it does not.
///
/// A part that is gone for one cut alone has been there all the time, and one that is there for
/// one cut alone is left out, and noted: such areas flicker. A part's area is that of each cut:
/// it slides as they do.
///
/// Errors: InvalidInput for no frames, times that do not rise, a hand that never touches (as
/// contactsOfPosedHand says it of the last frame). Cancelled on wish. Cost: that of
/// contactsOfPosedHand a cut.
manipulation::Motion motionOfPosedHand(const hand::Hand& hand,
                                       const std::vector<PosedFrame>& frames,
                                       const geometry::TriangleMesh& object_O,
                                       const PosedMotionOptions& options,
                                       const Progress& progress);

}  // namespace handgraft::demonstration
