#pragma once

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "core/base/background_task.h"
#include "core/manipulation/causal_solver.h"
#include "core/manipulation/contact_tracker.h"
#include "core/optimize/solve_report.h"
#include "core/quality/penetration.h"
#include "core/retargeting/going_along.h"
#include "core/retargeting/live_approach.h"
#include "core/retargeting/live_beginning.h"
#include "core/retargeting/live_glitches.h"
#include "core/retargeting/live_grasp.h"
#include "core/retargeting/live_looking.h"
#include "core/retargeting/live_searches.h"
#include "core/retargeting/live_way.h"
#include "core/session/document.h"

namespace handgraft::retargeting {

/// A hand that follows a demonstrator's, frame by frame as they come: where parts of the
/// demonstrator's hand touch the object, the same parts of this hand do (LiveGrasp), by the
/// causal solver, within limits and out of the object. Touches come and go within 60 ms.
///
/// Before it holds anything it comes near as the demonstrator's hand does (LiveApproach), and
/// shows what touches from there. When three parts or more touch and no more come, or two
/// fingers pinch (LiveBeginning), the best pose of that frame alone is searched (lookFor):
/// where it shows far more, the hand goes there. It lets go as the demonstrator's hand goes and
/// opens (GoingAlong), and forgets within half a second how it held. Where it is not told how
/// that hand is held it begins with the search, and stays over the object when nothing touches.
///
/// A hand that is 12 mm off on average for a quarter of a second is lost: it is searched in the
/// same way again, and where that is nearer by far it goes there, about the object, in 0.8 s at
/// most. So it is where a finger has touched for as long and none of the hand's shows it, and
/// where it is more than 2 mm inside the object.
///
/// Searches run beside the frames, which are answered meanwhile, and end 0.15 s of the frames'
/// time after they began, however long they took: the same frames have the same answers. One
/// that a hand without a pose, or frames farther apart, begins with is waited for.
///
/// After a pause of 0.25 s, or where time has run backwards by as much, it goes on from where
/// the hand is, at rest: one that holds nothing is where it is shown half a second later (at
/// once from the third pause in a row on: those are slow frames). One frame or two in which a
/// joint jumps as no finger moves, or the wrist as no arm does, are passed over: what touched
/// before them touches still. Deterministic. Cost: some tenths of a millisecond a frame, tens
/// of milliseconds once.
class LiveFollower {
 public:
  static constexpr int kTouchesToBegin = LiveBeginning::kTouchesToBegin;

  /// What counts of the document: as in solveMotion, but for what it says of patches.
  /// Errors: Cancelled on wish.
  LiveFollower(const session::Document& document,
               const hand::Hand& hand,
               std::shared_ptr<const geometry::TriangleMesh> object_O,
               const Progress& progress);
  LiveFollower(const LiveFollower&) = delete;  // its solver refers to its problem
  LiveFollower& operator=(const LiveFollower&) = delete;

  using PartFit = LiveGrasp::PartFit;

  struct Answer {
    hand::HandPose pose;         ///< in W: the hand's base where the object is now
    int touches = 0;             ///< of the demonstrator
    bool is_on_its_way = false;  ///< to a better pose, which was found elsewhere
    double objective = 0.0;
    int evaluations = 0;
    std::vector<PartFit> parts;  ///< of these touches that have a place on this hand
    quality::Depths depths;
    std::vector<optimize::ActiveLimit> limits;
  };

  /// Nothing before it has begun, unless it is known how the demonstrator's hand is held.
  /// Errors: InvalidInput, and nothing changes, for a time that does not lie behind the last
  /// one's and for what is not finite.
  std::optional<Answer> follow(const manipulation::DemonstratedFrame& frame,
                               const Progress& progress);

  /// The same of touches that somebody else has found, whose numbers of parts they bear: one
  /// follower is told by one of them alone. Frames: X_WO in W. While nothing touches and it is
  /// not told where the demonstrator's hand is, this one stays over the object.
  std::optional<Answer> follow(double time_s,
                               const Pose& X_WO,
                               const std::vector<manipulation::DetectedContact>& touches,
                               const manipulation::ShownHand& shown,
                               const Progress& progress);

  /// Of the demonstrator's last frame.
  [[nodiscard]] int touches() const { return grasp_.touches(); }

  /// Whether that frame told how the demonstrator's hand is held: not if its knuckles lie in
  /// one line.
  [[nodiscard]] bool knowsHowHeld() const { return knows_how_held_; }

 private:
  /// A search beside the frames; its answer is used at a set time, however long it took.
  struct Looking {
    using Task = BackgroundTask<std::optional<LookedFor>>;

    Looking(double answer_s, Task::Work work) : due_s(answer_s), task(std::move(work)) {}

    double due_s;
    Task task;
  };

  void requireLater(double time_s) const;
  void look(double time_s, bool deals_anew, const manipulation::ShownHand& shown);
  /// What is looked for, once it is due; nothing where no touch has a place on the hand.
  std::optional<LookedFor> lookedFor(const Progress& progress);
  void begin(double time_s,
             bool is_at_once,
             const manipulation::ShownHand& shown,
             const Progress& progress);
  void goTo(LiveGrasp better, double time_s);
  void lookAnew(double time_s,
                double step_s,
                const manipulation::ShownHand& shown,
                const Progress& progress);
  std::optional<hand::HandPose> comeNear(const manipulation::ShownHand& shown);
  std::optional<hand::HandPose> freeGoal(const manipulation::ShownHand& shown,
                                         const std::optional<hand::HandPose>& near_O);
  [[nodiscard]] optimize::PoseProblem problemHolding(
      const std::optional<hand::HandPose>& near_O) const;
  [[nodiscard]] optimize::PoseProblem problemLetGo(
      double firmness, const std::optional<hand::HandPose>& near_O) const;
  [[nodiscard]] optimize::PoseProblem problemTo(const hand::HandPose& goal_O) const;
  [[nodiscard]] bool isLed(double time_s) const;
  hand::HandPose goingOn(const hand::HandPose& goal_O);

  std::shared_ptr<const LiveSetting> setting_;
  manipulation::ContactTracker tracker_;
  manipulation::CausalSolver solver_;
  LiveGrasp grasp_;
  LiveGlitches glitches_;
  std::optional<double> last_s_;
  double depth_ = 0.0;  // m, of the last answer in the object
  bool has_begun_ = false;
  bool knows_how_held_ = false;
  LiveBeginning beginning_;
  LiveSearches searches_;

  /// A hand that goes on behind a pause: when, and where it was. Frames: O.
  struct Resumed {
    double time_s;
    hand::HandPose pose_O;
  };

  std::optional<LiveApproach> approach_;
  std::optional<GoingAlong> along_;
  std::optional<Resumed> resumed_;
  int pauses_ = 0;              // before the last frames, in a row
  double touched_s_ = 0.0;      // when something did last
  std::optional<LiveWay> way_;  // to a better pose that was found far from the hand
  std::optional<Looking> looking_;
};

}  // namespace handgraft::retargeting
