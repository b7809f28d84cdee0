#pragma once

#include <functional>
#include <list>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/manipulation/trajectory.h"
#include "core/manipulation/transfer_patches.h"
#include "core/retargeting/motion_solving.h"
#include "core/session/document.h"
#include "core/session/models.h"

namespace handgraft::retargeting {

/// Frames `first` to `end` of a motion.
struct FrameRange {
  int first = 0;
  int end = 0;
};

/// A session's motion, solved again and again while it is edited.
///
/// First the motion without edits at times (offline from the last such answer, if there is one,
/// else from nothing; from nothing, too, where an edit has patches missed that were reached:
/// the better counts), then what was edited at times, each stretch of frames about such edits
/// by itself: those that an edit reaches and kMargin_s on both sides, which smoothness couples
/// to them. The others keep the first answer to the byte. So one more edit at a time costs its
/// own stretch alone. Frame by frame (causal), every frame after an edit is solved anew.
///
/// Answers are kept: a document that was answered before, as after an undo, has the same answer
/// to the byte. What holds at times follows from the first answer and those edits alone.
///
/// Not thread-safe. Deterministic on any number of threads.
class EditedMotion {
 public:
  /// `motion` lies on `object_O`.
  EditedMotion(std::shared_ptr<const manipulation::Motion> motion,
               std::shared_ptr<const geometry::TriangleMesh> object_O);

  /// Told of stretches that were solved anew while others are not yet.
  using OnStretch = std::function<void(const SolvedMotion& as_far, FrameRange frames)>;

  /// `from_nothing`: not from the answer before, unless this very thing was answered.
  /// Errors: as solveMotion.
  std::shared_ptr<const SolvedMotion> solve(const session::Document& document,
                                            const hand::Hand& hand,
                                            MotionSolving solving,
                                            int threads,
                                            const Progress& progress,
                                            const OnStretch& on_stretch = OnStretch(),
                                            bool from_nothing = false);

  /// On both sides of what an edit reaches: twice what a hand that nothing holds settles in;
  /// one that touches is coupled over some 0.05 s.
  static constexpr double kMargin = 0.5;  // s

 private:
  /// The motion with what was edited for all of it, and its patches on the hand.
  struct Laid {
    std::string key;
    std::string hand;
    manipulation::Motion motion;
    manipulation::TransferredMotion laid;
  };

  /// An answer without edits at times, and what it answers.
  struct Base {
    std::string key;
    std::shared_ptr<const Laid> laid;
    std::shared_ptr<const SolvedMotion> solved;
  };

  /// A stretch about edits at times, solved.
  struct Stretch {
    std::string key;  ///< of its base and its edits
    std::vector<hand::HandPose> poses;
    std::vector<double> objective;
    std::vector<quality::Depths> depths;
  };

  struct Work;  ///< what one solve is about

  /// Where the base before has the patches, if there is one; else where the motion has them, or
  /// where they slide to: then `start` is a pose a frame to set out from.
  std::shared_ptr<const Laid> laid(const Work& work,
                                   bool anew,
                                   std::vector<hand::HandPose>& start);
  const Base& base(const Work& work);
  Base solveBase(const Work& work, bool goes_on);
  void solveStretches(const Work& work, SolvedMotion& solved, const OnStretch& on_stretch);

  std::shared_ptr<const manipulation::Motion> motion_;
  std::shared_ptr<const geometry::TriangleMesh> object_O_;
  contact::ContactSet grasp_;     ///< that stands for it
  std::list<Base> bases_;         ///< the last used first
  std::list<Stretch> stretches_;  ///< likewise
};

}  // namespace handgraft::retargeting
