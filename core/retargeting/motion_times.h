#pragma once

#include "core/base/progress.h"
#include "core/contact/contact_set.h"
#include "core/manipulation/motion_problem.h"
#include "core/manipulation/transfer_patches.h"
#include "core/session/document.h"
#include "core/session/models.h"

/// What a document says of a motion, laid into the problem of its frames.
namespace handgraft::retargeting {

/// The document's switches and weights of a patch, as shares of the patch's own.
double shareOf(const session::DocumentPatch& patch, double own);

/// Pairs of patches that are laid, as the document weighs them. `motion`: the one that was
/// laid; `grasp` stands for it. Errors: InvalidInput if all patches are switched off.
std::vector<manipulation::PairTrack> weighed(const session::Document& document,
                                             const contact::ContactSet& grasp,
                                             const manipulation::Motion& motion,
                                             manipulation::TransferredMotion laid);

/// Joints that are held softly and places that were dragged, for all of the motion.
void holdThroughout(const session::Document& document,
                    const manipulation::Fade& fade,
                    manipulation::MotionProblem& problem);

/// A motion as it was laid, for edits at times of it.
struct LaidOut {
  const session::Document& document;
  const hand::Hand& hand;
  const geometry::TriangleMesh& object_O;
  const manipulation::Motion& motion;  ///< roots and directions for all of it are edited
  const contact::ContactSet& grasp;    ///< stands for the motion, unedited
  const manipulation::TransferredMotion& laid;
  manipulation::Fade fade;
};

/// Puts the document's edits at times into `problem`, which has what holds throughout. Frames
/// that no such edit reaches stay as they are.
/// Errors: InvalidInput naming the patch that cannot be moved so.
void layAtTimes(const LaidOut& laid_out,
                const Progress& progress,
                manipulation::MotionProblem& problem);

}  // namespace handgraft::retargeting
