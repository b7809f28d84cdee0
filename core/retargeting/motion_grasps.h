#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/base/progress.h"
#include "core/contact/contact_set.h"
#include "core/hand/kinematics.h"
#include "core/manipulation/motion.h"
#include "core/manipulation/trajectory.h"
#include "core/session/document.h"
#include "core/session/models.h"
#include "core/transfer/patch_placement.h"

namespace handgraft::retargeting {

/// The fullest frame of each third of the motion, recorded points as disks about them. `grasp`:
/// the one that stands for it (graspOf).
std::vector<session::FrameContacts> frameContactsOf(const manipulation::Motion& motion,
                                                    const contact::ContactSet& grasp,
                                                    const geometry::TriangleMesh& object_O);

/// What a session of a motion is opened with, by the models' own names.
session::SessionModels modelsOfMotion(
    hand::Hand hand,
    const std::shared_ptr<const geometry::TriangleMesh>& object_O,
    const manipulation::Motion& motion);

/// A frame of a motion as a grasp: what a session finds of it alone.
struct FrameGrasp {
  int frame = 0;
  hand::HandPose pose_O;
  /// Of each track of the motion; nothing where it is not there, or has no place on the hand.
  std::vector<std::optional<transfer::PatchPlacement>> placements;
};

/// Searches the fullest frames, one of each part of the motion, as a session searches a grasp:
/// starts, slides, weights on what is missed (DerivedState::solve). What follows a whole motion
/// from frame to frame looks far less about.
///
/// `document`: of the grasp that stands for the motion, `grasp` its contacts, patches called by
/// the motion's names in the order of patchNames. Frames of which no patch has a place on the
/// hand are left out. Deterministic on any number of threads. Errors: Cancelled on wish.
/// Cost: a session's solve a frame.
std::vector<FrameGrasp> graspFrames(
    const session::Document& document,
    const hand::Hand& hand,
    const std::shared_ptr<const geometry::TriangleMesh>& object_O,
    const contact::ContactSet& grasp,
    const manipulation::Motion& motion,
    int threads,
    const Progress& progress);

/// To set out from.
std::vector<manipulation::FramePose> posesOf(const std::vector<FrameGrasp>& grasps);

/// Places of keys where the nearest grasp of their track has them; keys without one stay.
void placeAsGrasped(const std::vector<FrameGrasp>& grasps, manipulation::Motion& motion);

}  // namespace handgraft::retargeting
