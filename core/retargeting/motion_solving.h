#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/contact/contact_set.h"
#include "core/manipulation/motion.h"
#include "core/manipulation/motion_problem.h"
#include "core/manipulation/trajectory.h"
#include "core/quality/penetration.h"
#include "core/session/document.h"
#include "core/session/models.h"

namespace handgraft::retargeting {

/// How a session's motion is solved, beside what the document says.
struct MotionSolving {
  bool causal = false;
  manipulation::MotionOptions options;  ///< of the way chosen (`motionSolving`)
  double acceleration_limit = 0.0;      ///< rad/s^2 or m/s^2 of every joint; 0: none
};

/// The defaults of either way.
MotionSolving motionSolving(bool causal);

/// A hand that follows a motion, and how well.
struct SolvedMotion {
  MotionSolving solving;
  manipulation::MotionProblem problem;
  std::vector<int> track_of;  ///< of each of the problem's tracks: which of the motion's it is
  manipulation::Trajectory trajectory;  ///< poses in O
  std::vector<quality::Depths> depths;  ///< a frame
  /// The motion with what was edited for all of it, its patches where they lie on the hand.
  std::shared_ptr<const manipulation::Motion> laid;
  std::vector<std::string> notes;
};

/// A problem without contacts and solids yet: limits, locks, prior and weights of the document.
manipulation::MotionProblem motionProblemOf(const session::Document& document,
                                            const hand::Hand& hand,
                                            const std::vector<double>& time_s,
                                            const MotionSolving& solving);

/// The names of a motion's patches, each once, in the order of their first appearance.
std::vector<std::string> patchNames(const manipulation::Motion& motion);

/// Whether recorded points tell any of its patches.
bool isOfPoints(const manipulation::Motion& motion);

/// A key's patch as one of a grasp: a recorded point as a disk about it.
contact::Patch patchOfGrasp(const manipulation::PatchKey& key,
                            const geometry::TriangleMesh& object_O,
                            const geometry::SurfaceLocator& locator);

/// The grasp that stands for a motion where one is edited: each patch as it first appears;
/// recorded points as disks about them, called after their places on the hand.
contact::ContactSet graspOf(const manipulation::Motion& motion,
                            const geometry::TriangleMesh& object_O);

/// Lays a motion onto the hand and has the hand follow it.
///
/// What counts of the document: limits and locks of joints, the prior's joints, weights, the
/// form of normals, care for depth, the way patches are laid, and of each patch whether it is
/// enabled and its weight, by its name, roots and directions on the object where they were
/// edited, held places and joints, and edits at times (timed_edit.h). The same answer on any
/// number of `threads`. Errors: InvalidInput if no patch finds a place on the hand or all are
/// switched off, or an option is out of range; Cancelled on wish.
SolvedMotion solveMotion(const session::Document& document,
                         const hand::Hand& hand,
                         const std::shared_ptr<const geometry::TriangleMesh>& object_O,
                         const manipulation::Motion& motion,
                         MotionSolving solving,
                         int threads,
                         const Progress& progress);

/// How one patch fits in one frame.
struct PatchFrameFit {
  int patch = 0;  ///< of patchNames
  int track = 0;  ///< of the motion's
  double presence = 1.0;
  int points = 0;
  double mean_mm = 0.0;
  double normal_deg = 0.0;  ///< mean angle between the normals of both sides
  bool reached = false;     ///< as optimize::diagnose has it by default
};

/// Of the patches that are there, fading ones too; those that are switched off as not present.
class MotionFits {
 public:
  /// Keeps references.
  MotionFits(const manipulation::Motion& motion, const SolvedMotion& solved);

  /// Cost: O(pairs of the frame).
  [[nodiscard]] std::vector<PatchFrameFit> at(int frame) const;

 private:
  const SolvedMotion& solved_;
  std::vector<int> patch_of_track_;  ///< of the motion's tracks
  manipulation::FrameProblems frames_;
};

}  // namespace handgraft::retargeting
