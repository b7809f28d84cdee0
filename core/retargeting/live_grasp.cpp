#include "core/retargeting/live_grasp.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <utility>

#include "core/base/angle.h"
#include "core/contact/patch.h"
#include "core/optimize/diagnosis.h"
#include "core/placement/solids.h"
#include "core/retargeting/motion_solving.h"

namespace handgraft::retargeting {

namespace {

// Places yield to where the hand shows a touch like a spring.
constexpr double kSlideShare = 0.95;
// Of places kept for later frames.
constexpr double kAngleStep = std::numbers::pi / 36.0;  // rad
constexpr double kShareStep = 1.0 / 32.0;               // of a segment or the palm

/// In a touch that the hand is so far from showing (Cauchy's weight).
double trustIn(double distance) {
  constexpr double kHalf = 0.0125;  // m
  const double share = distance / kHalf;
  return 1.0 / (1.0 + share * share);
}

}  // namespace

LiveSetting::LiveSetting(const session::Document& document,
                         const hand::Hand& of_hand,
                         std::shared_ptr<const geometry::TriangleMesh> of_object_O,
                         const Progress& progress)
    : hand(of_hand),
      object_O(std::move(of_object_O)),
      coordinates(hand::coordinatesOf(hand)),
      problem(motionProblemOf(document, hand, {0.0}, motionSolving(true))),
      options(motionSolving(true).options),
      faces(placement::facesOf(hand.skin)),
      middle_O(object_O->vertices().rowwise().mean()),
      dofs_moving(hand::dofsMoving(*hand.model)) {
  placement::makeSolids(hand, object_O, progress);
  if (!document.solving.avoids()) return;
  problem.avoidance =
      placement::avoidanceOf(hand.model, hand.skin, object_O, Pose::Identity(), progress);
}

Eigen::Vector3d LiveGrasp::TouchingPart::shownPlace() const {
  return meant->p_L + kSlideShare * slide_L;
}

void LiveGrasp::TouchingPart::forget() {
  slide_L.setZero();
  turn_L.setZero();
  trust = 1.0;
}

LiveGrasp::LiveGrasp(std::shared_ptr<const LiveSetting> setting)
    : setting_(std::move(setting)),
      parts_(manipulation::ContactTracker::partNames().size()),
      fingers_(setting_->coordinates->anatomy()) {}

std::optional<hand::LinkPoint> LiveGrasp::spotOf(const manipulation::DetectedContact& touch) {
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
  if (const auto found = setting_->coordinates->spotAt(place))
    spot = setting_->hand.skin->project(found->root_S);
  spots_[key] = spot;
  return spot;
}

void LiveGrasp::meet(const manipulation::DetectedContact& touch) {
  TouchingPart& part = parts_[static_cast<std::size_t>(touch.part)];
  const std::optional<hand::LinkPoint> spot = spotOf(touch);
  const bool is_same_link = spot && part.meant && spot->link == part.meant->link;
  if (!is_same_link || part.presence == 0.0) part.forget();
  part.digit = touch.place.digit;
  part.meant = spot;
  part.p_O = positionOf(*setting_->object_O, touch.point_O);
  part.n_O = normalOf(*setting_->object_O, touch.point_O);
}

void LiveGrasp::comeAndGo(const std::vector<manipulation::DetectedContact>& touches,
                          double fade) {
  seen_ = touches;
  if (pose_O) takeFingers();
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
}

void LiveGrasp::goOnFrom(const LiveGrasp& other) {
  parts_.resize(std::max(parts_.size(), other.parts_.size()));
  seen_ = other.seen_;
  for (const manipulation::DetectedContact& touch : seen_)
    meet(touch);
  for (std::size_t i = 0; i < parts_.size(); ++i)
    parts_[i].presence = i < other.parts_.size() ? other.parts_[i].presence : 0.0;
}

void LiveGrasp::meetAnew() {
  for (const manipulation::DetectedContact& touch : seen_)
    meet(touch);
  for (TouchingPart& part : parts_)
    part.forget();
}

bool LiveGrasp::isTouching() const {
  return std::any_of(parts_.begin(), parts_.end(), [](const TouchingPart& part) {
    return part.presence > 0.0;
  });
}

std::vector<std::string> LiveGrasp::touchingDigits() const {
  std::vector<std::string> digits;
  for (const manipulation::DetectedContact& touch : seen_)
    if (touch.place.digit != hand::kPalmPart) digits.push_back(touch.place.digit);
  return session::inOrder(std::move(digits));
}

std::vector<char> LiveGrasp::holdingJoints() const {
  std::vector<char> hold(static_cast<std::size_t>(setting_->hand.model->dofCount()), 0);
  for (const TouchingPart& part : parts_) {
    if (!part.meant || part.presence <= 0.0) continue;
    for (const int dof : setting_->dofs_moving[static_cast<std::size_t>(part.meant->link)])
      hold[static_cast<std::size_t>(dof)] = 1;
  }
  return hold;
}

int LiveGrasp::partsTouching() const {
  std::set<std::string> parts;
  for (const manipulation::DetectedContact& touch : seen_)
    parts.insert(touch.place.digit);
  return static_cast<int>(parts.size());
}

void LiveGrasp::takeFingers() {
  std::vector<std::string> present = touchingDigits();
  const std::vector<std::string> touching = present;
  for (const TouchingPart& part : parts_)
    if (part.presence > 0.0) present.push_back(part.digit);
  fingers_.take(touching, present);
}

void LiveGrasp::keepFingers() {
  fingers_.choose(fingers_.dealing(), touchingDigits());
}

void LiveGrasp::deal(session::Dealing dealing) {
  fingers_.choose(std::move(dealing), touchingDigits());
  meetAnew();
}

void LiveGrasp::letGo() {
  fingers_ = LiveFingers(setting_->coordinates->anatomy());
}

void LiveGrasp::slide(double share) {
  const hand::Hand& hand = setting_->hand;
  const hand::LinkPoses X_SO = hand.skin->fromWorld(*hand.model, *pose_O);
  const hand::LinkPoses X_OL = hand::forwardKinematics(*hand.model, *pose_O);
  std::vector<char> permitted(hand.model->links().size(), 0);
  for (TouchingPart& part : parts_) {
    if (!part.meant || part.presence <= 0.0) continue;
    const auto link = static_cast<std::size_t>(part.meant->link);
    const double distance = (X_OL[link] * part.shownPlace() - part.p_O).norm();
    part.trust += share * (trustIn(distance) - part.trust);
    permitted[link] = 1;
    const auto shown_S =
        placement::rootShownBy(*setting_->faces, X_SO, permitted, part.p_O, part.n_O);
    permitted[link] = 0;
    const auto shown = shown_S ? hand.skin->project(*shown_S) : std::nullopt;
    if (!shown || shown->link != part.meant->link) continue;
    part.slide_L += share * (shown->p_L - part.meant->p_L - part.slide_L);
    part.turn_L += share * (shown->n_L - part.meant->n_L - part.turn_L);
  }
}

optimize::PointPair LiveGrasp::pairOf(std::size_t index) const {
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

optimize::PoseProblem LiveGrasp::problem() const {
  const manipulation::MotionProblem& motion = setting_->problem;
  hand::HandPose start;
  start.q = motion.prior.cwiseMax(motion.lower).cwiseMin(motion.upper);
  if (pose_O) start = *pose_O;
  optimize::PoseProblem single =
      manipulation::FrameProblems(motion, setting_->options.fade).at(0, start);
  for (std::size_t i = 0; i < parts_.size(); ++i)
    if (parts_[i].meant && parts_[i].presence > 0.0) single.pairs.push_back(pairOf(i));
  return single;
}

std::vector<LiveGrasp::PartFit> LiveGrasp::fitsOf(
    const std::vector<manipulation::DetectedContact>& touches, const Pose& X_WO) const {
  const hand::LinkPoses X_OL = hand::forwardKinematics(*setting_->hand.model, *pose_O);
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

LiveGrasp::Standing LiveGrasp::standing() const {
  Standing standing;
  const std::vector<PartFit> fits = fitsOf(seen_, Pose::Identity());
  standing.lack = static_cast<double>(seen_.size() - fits.size());
  double sum_mm = 0.0;
  for (const PartFit& fit : fits) {
    if (parts_[static_cast<std::size_t>(fit.part)].presence < 1.0) continue;
    standing.lack += 1.0 - trustIn(1e-3 * fit.distance_mm);
    sum_mm += fit.distance_mm;
    ++standing.shown;
  }
  if (standing.shown > 0) standing.distance = 1e-3 * sum_mm / standing.shown;
  return standing;
}

}  // namespace handgraft::retargeting
