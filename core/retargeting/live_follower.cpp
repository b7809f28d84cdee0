#include "core/retargeting/live_follower.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/error.h"
#include "core/base/smooth_step.h"
#include "core/manipulation/trajectory.h"
#include "core/optimize/diagnosis.h"
#include "core/placement/solids.h"
#include "core/retargeting/hand_goal.h"

namespace handgraft::retargeting {

namespace {

// Of a link on its way: little, so that what is in the way keeps it off.
constexpr double kWayWeight = 4.0;
// Of a link of a hand that comes near while the first parts touch: so that these hold it.
constexpr double kNearWeight = 0.1;
// Of a joint that holds nothing, to be as it is shown, beside what keeps it smooth.
constexpr double kShownShare = 0.03;
constexpr double kForgets = 0.5;         // s, in which a hand forgets how it held
constexpr double kCatchesUp = 0.5;       // s, with a demonstrator who was not seen for a while
constexpr int kMostPauses = 2;           // in a row; frames that are all so far apart are slow
constexpr double kSlideTime = 0.05;      // s
constexpr double kLongestStep = 0.0125;  // s
constexpr double kSearchTime = 0.15;     // s; twice what most searches take

// Lost is a hand that is so far off, for so long; what is found must be nearer by this factor.
constexpr double kLost = 0.012;  // m, on average over the touches
constexpr double kBetter = 0.6;
// Fingers dealt in another way must leave so much less unshown to be worth the way there.
constexpr double kServesMore = 0.75;
// What is found for a hand that has come near must show so much more of what touches.
constexpr double kShowsMore = 0.3;

/// The same, and as firmly to a pose.
optimize::PoseProblem pulled(optimize::PoseProblem single,
                             const hand::HandModel& model,
                             const hand::HandPose& goal_O,
                             double weight) {
  const std::vector<optimize::PointPair> pull = pairsTo(model, goal_O, weight);
  single.pairs.insert(single.pairs.end(), pull.begin(), pull.end());
  return single;
}

}  // namespace

LiveFollower::LiveFollower(const session::Document& document,
                           const hand::Hand& hand,
                           std::shared_ptr<const geometry::TriangleMesh> object_O,
                           const Progress& progress)
    : setting_(std::make_shared<LiveSetting>(document, hand, std::move(object_O), progress)),
      tracker_(*setting_->object_O),
      solver_(setting_->problem, setting_->options),
      grasp_(setting_) {}

void LiveFollower::requireLater(double time_s) const {
  if (!std::isfinite(time_s)) rejectInput("a frame's time {} s is not finite", time_s);
  if (!last_s_) return;
  const double step_s = time_s - *last_s_;
  if (step_s <= 0.0 && step_s > -kLivePause) {
    rejectInput("a frame at {} s does not lie behind the one before it, {} s", time_s,
                *last_s_);
  }
}

std::optional<LiveFollower::Answer> LiveFollower::follow(
    const manipulation::DemonstratedFrame& frame, const Progress& progress) {
  requireLater(frame.time_s);
  if (const manipulation::DemonstratedFrame* steady = glitches_.steadyBefore(frame)) {
    return follow(frame.time_s, frame.X_WO, grasp_.seen(), manipulation::shownBy(*steady),
                  progress);
  }
  const std::vector<manipulation::DetectedContact> touches = tracker_.see(frame);
  glitches_.takeSteady(frame);
  return follow(frame.time_s, frame.X_WO, touches, manipulation::shownBy(frame), progress);
}

// === Searches

void LiveFollower::look(double time_s, bool deals_anew, const manipulation::ShownHand& shown) {
  looking_.emplace(time_s + kSearchTime, [from = grasp_, deals_anew,
                                          posture = shown.posture](const Progress& progress) {
    return lookFor(from, deals_anew, posture, progress);
  });
}

std::optional<LookedFor> LiveFollower::lookedFor(const Progress& progress) {
  std::optional<LookedFor> looked = looking_->task.get(progress);
  looking_.reset();
  return looked;
}

/// From where the hand is.
void LiveFollower::goTo(LiveGrasp better, double time_s) {
  const hand::HandPose here_O = *grasp_.pose_O;
  way_.emplace(here_O, *better.pose_O, setting_->middle_O, time_s);
  grasp_ = std::move(better);
  grasp_.pose_O = here_O;
}

void LiveFollower::begin(double time_s,
                         bool is_at_once,
                         const manipulation::ShownHand& shown,
                         const Progress& progress) {
  const bool is_due = beginning_.isDue(time_s, touches(), grasp_.partsTouching());
  std::optional<LookedFor> looked;
  if (looking_) {
    if (time_s < looking_->due_s) return;
    looked = lookedFor(progress);
    if (!is_due) return;  // who has touched is gone
  } else if (is_due && is_at_once) {
    looked = lookFor(grasp_, true, shown.posture, progress);
  } else if (is_due) {
    look(time_s, true, shown);
  }
  if (!looked || (looked->depth > kDeep && beginning_.putOff(time_s))) return;
  has_begun_ = true;
  looked->grasp.goOnFrom(grasp_);
  if (!is_at_once) {
    const LiveGrasp::Standing before = grasp_.standing();
    const LiveGrasp::Standing after = looked->grasp.standing();
    const bool shows_more = before.lack - after.lack >= kShowsMore * touches();
    const bool is_nearer =
        before.distance > kLost && after.distance < kBetter * before.distance;
    if (shows_more || is_nearer || depth_ > kDeep) goTo(std::move(looked->grasp), time_s);
    return;
  }
  grasp_ = std::move(looked->grasp);
  solver_.begin(*grasp_.pose_O);
}

void LiveFollower::lookAnew(double time_s,
                            double step_s,
                            const manipulation::ShownHand& shown,
                            const Progress& progress) {
  const LiveGrasp::Standing before = grasp_.standing();
  const std::vector<std::string> touching = grasp_.touchingDigits();
  const bool may_look = touches() >= kTouchesToBegin;
  const bool is_lost = may_look && (before.distance > kLost || depth_ > kDeep);
  const bool is_chosen = grasp_.fingers().isChosenFor(touching);
  const bool is_unserved = may_look && grasp_.fingers().lacksOneFor(touching) && !is_chosen;
  searches_.see(step_s, is_lost, is_unserved);
  if (!is_chosen) searches_.touchesChanged();
  if (!looking_) {
    if (!isLed(time_s) && searches_.isDue(time_s)) look(time_s, !is_chosen, shown);
    return;
  }
  if (time_s < looking_->due_s) return;
  std::optional<LookedFor> looked = lookedFor(progress);
  const bool is_of_these = looked && looked->grasp.touchingDigits() == touching;
  if (looked && may_look) {
    LiveGrasp& found = looked->grasp;
    found.goOnFrom(grasp_);
    const LiveGrasp::Standing after = found.standing();
    const bool serves_more = found.fingers().dealing() != grasp_.fingers().dealing() &&
                             after.lack < kServesMore * before.lack;
    const bool is_nearer =
        after.shown >= before.shown && after.distance < kBetter * before.distance;
    const bool is_freed = depth_ > kDeep && looked->depth <= kDeep;
    const bool is_caught = looked->depth > kDeep && looked->depth > depth_;
    if (!is_caught && (serves_more || is_nearer || is_freed)) {
      goTo(std::move(found), time_s);
      searches_.found(way_->end());
      return;
    }
  }
  searches_.foundNothing(time_s);
  if (is_of_these) grasp_.keepFingers();
}

// === What holds nothing

/// Where the hand is before it has begun, if that is known.
std::optional<hand::HandPose> LiveFollower::comeNear(const manipulation::ShownHand& shown) {
  if (!approach_) approach_ = LiveApproach::from(setting_->hand, shown);
  if (!approach_) return std::nullopt;
  const manipulation::MotionProblem& problem = setting_->problem;
  const auto goal_O = approach_->goal(shown, problem.lower, problem.upper);
  if (goal_O && !grasp_.pose_O) {
    grasp_.pose_O = goal_O;
    solver_.begin(*goal_O);
  }
  return goal_O;
}

/// Who was not seen for a while may be far from where this hand has waited.
hand::HandPose LiveFollower::goingOn(const hand::HandPose& goal_O) {
  if (!resumed_) return goal_O;
  const double share = (*last_s_ - resumed_->time_s) / kCatchesUp;
  const hand::HandPose from_O = resumed_->pose_O;
  if (share >= 1.0) resumed_.reset();
  return manipulation::poseBetween(from_O, goal_O, smoothStep(share));
}

/// Where the hand goes if nothing holds it, and near the object before it has begun.
std::optional<hand::HandPose> LiveFollower::freeGoal(
    const manipulation::ShownHand& shown, const std::optional<hand::HandPose>& near_O) {
  const std::optional<hand::HandPose> unless_held =
      has_begun_ ? std::optional<hand::HandPose>() : near_O;
  if (!shown.X_OD || !grasp_.pose_O) return unless_held;
  if (grasp_.isTouching()) {
    touched_s_ = *last_s_;
    along_.emplace(*shown.X_OD, shown.posture, *grasp_.pose_O);
    return unless_held;
  }
  way_.reset();  // it leads to what is held no more
  if (!along_) return unless_held;
  const manipulation::MotionProblem& problem = setting_->problem;
  const hand::HandPose as_held_O =
      along_->goal(setting_->hand, *shown.X_OD, shown.posture, problem.lower, problem.upper);
  if (!near_O) return as_held_O;
  const double share = std::clamp((*last_s_ - touched_s_) / kForgets, 0.0, 1.0);
  if (share == 1.0) {
    has_begun_ = false;
    along_.reset();
    looking_.reset();
    grasp_.letGo();
  }
  return manipulation::poseBetween(as_held_O, *near_O, smoothStep(share));
}

/// What touches nothing stands as it does near the object.
optimize::PoseProblem LiveFollower::problemHolding(
    const std::optional<hand::HandPose>& near_O) const {
  optimize::PoseProblem single = grasp_.problem();
  if (!near_O || !(single.weights.prior > 0.0)) return single;
  const double weight = kShownShare * setting_->options.smoothness / single.weights.prior;
  const std::vector<char> hold = grasp_.holdingJoints();
  for (Eigen::Index joint = 0; joint < near_O->q.size(); ++joint) {
    if (hold[static_cast<std::size_t>(joint)] != 0) continue;
    single.prior.q[joint] = near_O->q[joint];
    single.prior_weights[6 + joint] = weight;
  }
  return single;
}

optimize::PoseProblem LiveFollower::problemTo(const hand::HandPose& goal_O) const {
  const hand::HandModel& model = *setting_->hand.model;
  if (!has_begun_ && grasp_.isTouching()) {
    return pulled(problemHolding(goal_O), model, goal_O, kNearWeight);
  }
  optimize::PoseProblem single = grasp_.problem();
  // What is inside would keep the hand there.
  if (has_begun_ && depth_ > kDeep) single.avoidance = {};
  single.pairs = pairsTo(model, goal_O, kWayWeight);
  return single;
}

/// By the end of its way, `firmness` of what that held it: the rest what touches does.
optimize::PoseProblem LiveFollower::problemLetGo(
    double firmness, const std::optional<hand::HandPose>& near_O) const {
  optimize::PoseProblem single = problemHolding(near_O);
  for (optimize::PointPair& pair : single.pairs)
    pair.weight *= 1.0 - firmness;
  return pulled(std::move(single), *setting_->hand.model, way_->at(way_->end()),
                firmness * firmness * kWayWeight);
}

/// Alone by its way: what touches has no say yet.
bool LiveFollower::isLed(double time_s) const {
  return way_ && time_s <= way_->end();
}

// === A frame

std::optional<LiveFollower::Answer> LiveFollower::follow(
    double time_s,
    const Pose& X_WO,
    const std::vector<manipulation::DetectedContact>& touches,
    const manipulation::ShownHand& shown,
    const Progress& progress) {
  requireLater(time_s);
  const double step_s = last_s_ ? time_s - *last_s_ : 0.0;
  const bool paused = last_s_ && (step_s > kLivePause || step_s <= 0.0);
  last_s_ = time_s;
  knows_how_held_ = shown.X_OD.has_value();

  // === Parts come and go
  const double fade_s = setting_->options.fade.seconds;
  const bool fades = fade_s > 0.0 && !paused && grasp_.pose_O;
  grasp_.comeAndGo(touches, fades ? std::max(0.0, step_s) / fade_s : 1.0);

  // === The pose
  if (paused) {
    looking_.reset();
    way_.reset();
    resumed_.reset();
    if (grasp_.pose_O) {
      solver_.begin(*grasp_.pose_O);
      if (pauses_ < kMostPauses) resumed_ = Resumed{time_s, *grasp_.pose_O};
    }
    searches_.beginAnew(time_s);
    touched_s_ = time_s;
  }
  pauses_ = paused ? pauses_ + 1 : 0;
  const bool begins = !grasp_.pose_O;
  if (!has_begun_)
    begin(time_s, begins || paused, shown, progress);
  else if (!paused)
    lookAnew(time_s, step_s, shown, progress);
  const std::optional<hand::HandPose> near_O = comeNear(shown);
  std::optional<hand::HandPose> free_O = freeGoal(shown, near_O);
  if (has_begun_ && grasp_.isTouching()) resumed_.reset();  // it is where it holds
  if (free_O) free_O = goingOn(*free_O);
  // Nothing of so long ago holds it back.
  if (pauses_ > kMostPauses && free_O && !grasp_.isTouching()) solver_.begin(*free_O);
  if (!has_begun_ && !free_O) return std::nullopt;
  // Of frames that are far apart in several steps: places follow the hand, and it them.
  const int steps =
      paused || begins ? 1
                       : std::max(1, static_cast<int>(std::ceil(step_s / kLongestStep - 1e-6)));
  manipulation::CausalSolver::Step step;
  for (int i = steps - 1; i >= 0; --i) {
    const double now_s = time_s - i * step_s / steps;
    const double firmness = way_ ? way_->firmness(now_s) : 0.0;
    if (firmness == 0.0) way_.reset();
    const bool is_led = isLed(now_s);
    step = solver_.follow(now_s, is_led   ? problemTo(way_->at(now_s))
                                 : way_   ? problemLetGo(firmness, near_O)
                                 : free_O ? problemTo(*free_O)
                                          : problemHolding(near_O));
    grasp_.pose_O = step.pose;
    if (!is_led) grasp_.slide(1.0 - std::exp(-std::max(0.0, step_s) / steps / kSlideTime));
  }
  Answer answer;
  answer.pose = {X_WO * step.pose.X_WH, step.pose.q};
  answer.touches = this->touches();
  answer.is_on_its_way = isLed(time_s);
  answer.objective = step.objective;
  answer.evaluations = step.evaluations;
  answer.parts = grasp_.fitsOf(touches, X_WO);
  answer.depths = placement::depthsOf(setting_->hand.model, setting_->hand.skin,
                                      setting_->object_O, step.pose, progress);
  if (setting_->problem.avoidance) depth_ = answer.depths.object_m;
  answer.limits =
      optimize::activeLimits(setting_->problem.lower, setting_->problem.upper, step.pose.q);
  return answer;
}

}  // namespace handgraft::retargeting
