#include "core/retargeting/live_follower.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "core/base/angle.h"
#include "core/base/error.h"
#include "core/contact/patch.h"
#include "core/optimize/diagnosis.h"
#include "core/placement/solids.h"
#include "core/retargeting/hand_goal.h"

namespace handgraft::retargeting {

namespace {

// Of a link on its way: little, so that what is in the way keeps it off.
constexpr double kWayWeight = 4.0;
// Places yield to where the hand shows a touch like a spring.
constexpr double kSlideShare = 0.95;
constexpr double kSlideTime = 0.05;      // s
constexpr double kLongestStep = 0.0125;  // s
// Of places kept for later frames.
constexpr double kAngleStep = std::numbers::pi / 36.0;  // rad
constexpr double kShareStep = 1.0 / 32.0;               // of a segment or the palm

}  // namespace

LiveFollower::LiveFollower(const session::Document& document,
                           const hand::Hand& hand,
                           std::shared_ptr<const geometry::TriangleMesh> object_O,
                           const Progress& progress)
    : hand_(hand),
      object_O_(std::move(object_O)),
      coordinates_(*hand_.model, *hand_.skin, hand_.sites),
      problem_(motionProblemOf(document, hand, {0.0}, motionSolving(true))),
      options_(motionSolving(true).options),
      tracker_(*object_O_),
      solver_(problem_, options_),
      faces_(placement::facesOf(hand_.skin)),
      middle_O_(object_O_->vertices().rowwise().mean()),
      parts_(manipulation::ContactTracker::partNames().size()),
      fingers_(coordinates_.anatomy()) {
  placement::makeSolids(hand_, object_O_, progress);
  if (!document.solving.avoids()) return;
  problem_.avoidance =
      placement::avoidanceOf(hand_.model, hand_.skin, object_O_, Pose::Identity(), progress);
}

std::optional<hand::LinkPoint> LiveFollower::spotOf(
    const manipulation::DetectedContact& touch) {
  const auto steps = [](double value, double step) {
    return static_cast<int>(std::lround(value / step));
  };
  hand::HandLocation place = touch.place;
  if (place.digit != hand::kPalmPart) {
    const std::string* finger = fingers_.fingerFor(place.digit);
    if (finger == nullptr) return std::nullopt;
    place.digit = *finger;
  }
  const PlaceKey key{place.digit, touch.part, steps(touch.place.along, kShareStep),
                     steps(touch.place.around_rad, kAngleStep),
                     steps(touch.place.across, kShareStep)};
  const auto known = spots_.find(key);
  if (known != spots_.end()) return known->second;
  place.along = key.along * kShareStep;
  place.around_rad = key.around * kAngleStep;
  place.across = key.across * kShareStep;
  std::optional<hand::LinkPoint> spot;
  if (const auto found = coordinates_.spotAt(place)) spot = hand_.skin->project(found->root_S);
  spots_[key] = spot;
  return spot;
}

void LiveFollower::meet(const manipulation::DetectedContact& touch) {
  TouchingPart& part = parts_[static_cast<std::size_t>(touch.part)];
  const std::optional<hand::LinkPoint> spot = spotOf(touch);
  const bool is_same_link = spot && part.meant && spot->link == part.meant->link;
  if (!is_same_link || part.presence == 0.0) part.forget();
  part.digit = touch.place.digit;
  part.meant = spot;
  part.p_O = positionOf(*object_O_, touch.point_O);
  part.n_O = normalOf(*object_O_, touch.point_O);
}

/// Each touch from now on, by the fingers as they are dealt.
void LiveFollower::meetAnew() {
  for (const manipulation::DetectedContact& touch : seen_)
    meet(touch);
  for (TouchingPart& part : parts_)
    part.forget();
}

/// Of the demonstrator, thumb to little.
std::vector<std::string> LiveFollower::touchingDigits() const {
  std::vector<std::string> digits;
  for (const manipulation::DetectedContact& touch : seen_)
    if (touch.place.digit != hand::kPalmPart) digits.push_back(touch.place.digit);
  return session::inOrder(std::move(digits));
}

/// Digits, and the palm.
int LiveFollower::partsTouching() const {
  std::set<std::string> parts;
  for (const manipulation::DetectedContact& touch : seen_)
    parts.insert(touch.place.digit);
  return static_cast<int>(parts.size());
}

/// For digits that have come since fingers were dealt.
void LiveFollower::takeFingers() {
  std::vector<std::string> present = touchingDigits();
  const std::vector<std::string> touching = present;
  for (const TouchingPart& part : parts_)
    if (part.presence > 0.0) present.push_back(part.digit);
  fingers_.take(touching, present);
}

/// In a touch that the hand is so far from showing (Cauchy's weight).
double LiveFollower::trustIn(double distance) {
  constexpr double kHalf = 0.0125;  // m
  const double share = distance / kHalf;
  return 1.0 / (1.0 + share * share);
}

Eigen::Vector3d LiveFollower::TouchingPart::shownPlace() const {
  return meant->p_L + kSlideShare * slide_L;
}

void LiveFollower::TouchingPart::forget() {
  slide_L.setZero();
  turn_L.setZero();
  trust = 1.0;
}

/// Places to where the hand shows what is touched, and trust to what it shows.
void LiveFollower::slide(double share) {
  const hand::LinkPoses X_SO = hand_.skin->fromWorld(*hand_.model, *last_O_);
  hand::LinkPoses X_OL;
  hand::forwardKinematics(*hand_.model, last_O_->X_WH, last_O_->q, X_OL);
  std::vector<char> permitted(hand_.model->links().size(), 0);
  for (TouchingPart& part : parts_) {
    if (!part.meant || part.presence <= 0.0) continue;
    const auto link = static_cast<std::size_t>(part.meant->link);
    const double distance = (X_OL[link] * part.shownPlace() - part.p_O).norm();
    part.trust += share * (trustIn(distance) - part.trust);
    permitted[link] = 1;
    const auto shown_S = placement::rootShownBy(*faces_, X_SO, permitted, part.p_O, part.n_O);
    permitted[link] = 0;
    const auto shown = shown_S ? hand_.skin->project(*shown_S) : std::nullopt;
    if (!shown || shown->link != part.meant->link) continue;
    part.slide_L += share * (shown->p_L - part.meant->p_L - part.slide_L);
    part.turn_L += share * (shown->n_L - part.meant->n_L - part.turn_L);
  }
}

optimize::PointPair LiveFollower::pairOf(std::size_t index) const {
  const TouchingPart& part = parts_[index];
  optimize::PointPair pair;
  pair.link = part.meant->link;
  pair.p_L = part.shownPlace();
  pair.n_L = (part.meant->n_L + kSlideShare * part.turn_L).normalized();
  pair.p_W = part.p_O;  // the object's frame is the solver's world
  pair.n_W = part.n_O;
  // It stands for a region.
  pair.weight = part.presence * part.trust * contact::kDefaultInterpolationCount;
  pair.patch = static_cast<int>(index);
  return pair;
}

optimize::PoseProblem LiveFollower::problemNow() const {
  hand::HandPose start;
  start.q = problem_.prior.cwiseMax(problem_.lower).cwiseMin(problem_.upper);
  if (last_O_) start = *last_O_;
  const manipulation::FrameProblems frames(problem_, options_.fade);
  optimize::PoseProblem single = frames.at(0, start);
  for (std::size_t i = 0; i < parts_.size(); ++i)
    if (parts_[i].meant && parts_[i].presence > 0.0) single.pairs.push_back(pairOf(i));
  return single;
}

std::vector<LiveFollower::PartFit> LiveFollower::fitsOf(
    const std::vector<manipulation::DetectedContact>& touches, const Pose& X_WO) const {
  hand::LinkPoses X_OL;
  hand::forwardKinematics(*hand_.model, last_O_->X_WH, last_O_->q, X_OL);
  std::vector<PartFit> fits;
  for (const manipulation::DetectedContact& touch : touches) {
    const auto index = static_cast<std::size_t>(touch.part);
    if (!parts_[index].meant) continue;
    const optimize::PointPair pair = pairOf(index);
    const Pose& X = X_OL[static_cast<std::size_t>(pair.link)];
    PartFit fit;
    fit.part = touch.part;
    fit.on_hand_W = X_WO * (X * pair.p_L);
    fit.on_object_W = X_WO * pair.p_W;
    fit.distance_mm = 1e3 * (fit.on_hand_W - fit.on_object_W).norm();
    fit.facing_deg = inDegrees(angleBetween(X.linear() * pair.n_L, -pair.n_W));
    fit.reached = optimize::isReached(fit.distance_mm, fit.facing_deg);
    fits.push_back(fit);
  }
  return fits;
}

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
    return follow(frame.time_s, frame.X_WO, seen_, manipulation::postureOf(*steady), progress,
                  manipulation::palmOf(*steady));
  }
  const std::vector<manipulation::DetectedContact> touches = tracker_.see(frame);
  glitches_.takeSteady(frame);
  return follow(frame.time_s, frame.X_WO, touches, manipulation::postureOf(frame), progress,
                manipulation::palmOf(frame));
}

/// Keeps where both hands are while something touches; else where this one goes.
std::optional<hand::HandPose> LiveFollower::leaveFor(
    const std::vector<contact::PartDirection>& posture, const Pose& X_OD) {
  const bool touches = std::any_of(parts_.begin(), parts_.end(), [](const TouchingPart& part) {
    return part.presence > 0.0;
  });
  // Who lets go has opened the hand already where the last part leaves.
  most_seen_ = touches ? std::max(most_seen_, seen_.size()) : 0;
  if (touches && 2 * seen_.size() >= most_seen_) along_.emplace(X_OD, posture, *last_O_);
  if (touches || !along_) return std::nullopt;
  return along_->goal(hand_, X_OD, posture, problem_.lower, problem_.upper);
}

optimize::PoseProblem LiveFollower::problemTo(const hand::HandPose& goal_O) const {
  optimize::PoseProblem single = problemNow();
  // What is inside would keep the hand there.
  if (depth_ > kDeep) single.avoidance = {};
  single.pairs = pairsTo(*hand_.model, goal_O, kWayWeight);
  return single;
}

/// Which parts touch now; of what comes and goes no more than `fade` in this frame.
std::vector<char> LiveFollower::comeAndGo(
    const std::vector<manipulation::DetectedContact>& touches, double fade) {
  std::vector<char> is_there(parts_.size(), 0);
  for (const manipulation::DetectedContact& touch : touches) {
    const auto at = static_cast<std::size_t>(touch.part);
    if (at >= parts_.size()) {
      parts_.resize(at + 1);
      is_there.resize(at + 1, 0);
    }
    is_there[at] = 1;
    meet(touch);
  }
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    const double goal = is_there[i];
    parts_[i].presence += std::clamp(goal - parts_[i].presence, -fade, fade);
  }
  return is_there;
}

std::optional<LiveFollower::Answer> LiveFollower::follow(
    double time_s,
    const Pose& X_WO,
    const std::vector<manipulation::DetectedContact>& touches,
    const std::vector<contact::PartDirection>& posture,
    const Progress& progress,
    const std::optional<Pose>& X_OD) {
  requireLater(time_s);
  const double step_s = last_s_ ? time_s - *last_s_ : 0.0;
  const bool paused = last_s_ && (step_s > kLivePause || step_s <= 0.0);
  last_s_ = time_s;
  seen_ = touches;
  if (last_O_) takeFingers();

  // === Parts come and go
  const double fade = options_.fade.seconds > 0.0 && !paused
                          ? std::max(0.0, step_s) / options_.fade.seconds
                          : 1.0;
  const std::vector<char> is_there = comeAndGo(touches, fade);

  // === The pose
  const bool begins = !last_O_;
  if (begins) {
    for (std::size_t i = 0; i < parts_.size(); ++i)
      parts_[i].presence = is_there[i];
    if (!begin(time_s, posture, progress)) return std::nullopt;
  } else if (paused) {
    solver_.begin(*last_O_);
    searches_.beginAnew(time_s);
  }
  if (!paused) lookAnew(time_s, step_s, posture, progress);
  // Of frames that are far apart in several steps: places follow the hand, and it them.
  const int steps =
      paused || begins ? 1
                       : std::max(1, static_cast<int>(std::ceil(step_s / kLongestStep - 1e-6)));
  const std::optional<hand::HandPose> away_O =
      X_OD ? leaveFor(posture, *X_OD) : std::optional<hand::HandPose>();
  manipulation::CausalSolver::Step step;
  for (int i = steps - 1; i >= 0; --i) {
    const double now_s = time_s - i * step_s / steps;
    if (way_ && (paused || now_s > way_->end())) way_.reset();
    step = solver_.follow(now_s, way_     ? problemTo(way_->at(now_s))
                                 : away_O ? problemTo(*away_O)
                                          : problemNow());
    last_O_ = step.pose;
    if (!way_) slide(1.0 - std::exp(-std::max(0.0, step_s) / steps / kSlideTime));
  }
  Answer answer;
  answer.pose = {X_WO * step.pose.X_WH, step.pose.q};
  answer.touches = this->touches();
  answer.is_on_its_way = way_.has_value();
  answer.objective = step.objective;
  answer.evaluations = step.evaluations;
  answer.parts = fitsOf(touches, X_WO);
  answer.depths = placement::depthsOf(hand_.model, hand_.skin, object_O_, step.pose, progress);
  if (problem_.avoidance) depth_ = answer.depths.object_m;
  answer.limits = optimize::activeLimits(problem_.lower, problem_.upper, step.pose.q);
  return answer;
}

}  // namespace handgraft::retargeting
