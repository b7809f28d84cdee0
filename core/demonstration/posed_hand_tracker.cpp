#include "core/demonstration/posed_hand_tracker.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/demonstration/shown_posture.h"
#include "core/hand/finger_coordinates.h"
#include "core/placement/solids.h"

namespace handgraft::demonstration {

namespace {

using manipulation::DetectedContact;

// What is nearer than that to a part's nearest sample belongs to its touch.
constexpr double kTouchDepth = 0.003;  // m
constexpr double kTipFrom = 0.75;      // of the last segment

struct PalmSpot {
  double along = 0.0;
  double across = 0.0;
};

// As ContactTracker parts a palm.
constexpr std::array<PalmSpot, 3> kPalmSpots{{{0.1, 0.2}, {0.1, 0.8}, {0.75, 0.6}}};

int palmPartOf(const hand::HandLocation& place) {
  const auto way_to = [&place](const PalmSpot& spot) {
    return std::hypot(spot.along - place.along, spot.across - place.across);
  };
  const auto* nearest =
      std::min_element(kPalmSpots.begin(), kPalmSpots.end(), [&](const auto& a, const auto& b) {
        return way_to(a) < way_to(b);
      });
  return static_cast<int>(nearest - kPalmSpots.begin());
}

bool isTip(const hand::HandLocation& place) {
  return place.segment == "distal" && place.along > kTipFrom;
}

/// The part of a hand that a place belongs to.
std::string partOf(const hand::HandLocation& place) {
  if (place.digit == hand::kPalmPart)
    return fmt::format("{}_{}", place.digit, 1 + palmPartOf(place));
  return hand::partName(place.digit, isTip(place) ? "tip" : place.segment);
}

}  // namespace

PosedHandTracker::PosedHandTracker(const hand::Hand& hand,
                                   std::shared_ptr<const geometry::TriangleMesh> object_O,
                                   const Progress& progress)
    : hand_(hand),
      object_O_(std::move(object_O)),
      solid_(placement::solidOf(hand_.model, hand_.skin, progress)),
      object_solid_O_(placement::solidOf(object_O_, progress)),
      locator_(*object_O_),
      grip_(hand_) {
  const std::shared_ptr<const hand::FingerCoordinates> coordinates = hand::coordinatesOf(hand_);
  turned_ = turnedParts(coordinates->anatomy());
  std::map<std::string, int> numbers;
  for (const hand::LinkSolid& link : solid_->links()) {
    std::vector<Spot>& spots = spots_.emplace_back();
    for (const hand::SurfaceSample& sample : link.fine.samples) {
      progress.checkpoint();
      Spot& spot = spots.emplace_back();
      const auto place = coordinates->placeOf(hand_.skin->skinPointOf(link.link, sample.p_L));
      if (!place) continue;
      spot.place = *place;
      const std::string name = partOf(*place);
      const auto [known, is_new] = numbers.try_emplace(name, static_cast<int>(numbers.size()));
      if (is_new) part_names_.push_back(name);
      spot.part = known->second;
    }
  }
  touches_.assign(part_names_.size(), 0);
}

std::vector<PosedHandTracker::Near> PosedHandTracker::nearSamples(
    const hand::LinkPoses& X_OL) const {
  std::vector<Near> near;
  for (std::size_t i = 0; i < spots_.size(); ++i) {
    const hand::LinkSolid& link = solid_->links()[i];
    const Pose& X = X_OL[static_cast<std::size_t>(link.link)];
    link.fine.visit(
        [&](const Eigen::Vector3d& centre_L, double radius) {
          return object_solid_O_->grid().isClear(X * centre_L, radius + kEnd);
        },
        [&](const hand::SurfaceSample& sample) {
          const Spot& spot =
              spots_[i][static_cast<std::size_t>(&sample - link.fine.samples.data())];
          if (spot.part < 0) return;
          const Eigen::Vector3d p_O = X * sample.p_L;
          const double distance = object_solid_O_->grid().at(p_O);
          if (distance > kEnd) return;
          near.push_back({spot.part, &spot, p_O, distance, sample.area_m2});
        });
  }
  std::stable_sort(near.begin(), near.end(), [](const Near& a, const Near& b) {
    return a.part < b.part;
  });
  return near;
}

DetectedContact PosedHandTracker::middleOf(const std::vector<Near>& near,
                                           double& distance) const {
  const auto nearest =
      std::min_element(near.begin(), near.end(), [](const Near& a, const Near& b) {
        return a.distance < b.distance;
      });
  double sum = 0.0;
  Eigen::Vector3d p_O = Eigen::Vector3d::Zero();
  Eigen::Vector2d around = Eigen::Vector2d::Zero();
  hand::HandLocation place = nearest->spot->place;
  place.along = 0.0;
  place.across = 0.0;
  place.from_tip = -1.0;
  for (const Near& one : near) {
    const double nearness =
        std::max(0.0, 1.0 - (one.distance - nearest->distance) / kTouchDepth);
    const double weight = one.area_m2 * nearness * nearness;  // comes and goes without a step
    const hand::HandLocation& at = one.spot->place;
    sum += weight;
    p_O += weight * one.p_O;
    around += weight * Eigen::Vector2d(std::cos(at.around_rad), std::sin(at.around_rad));
    place.along += weight * at.along;
    place.across += weight * at.across;
  }
  place.along /= sum;
  place.across /= sum;
  place.around_rad = std::atan2(around.y(), around.x());
  const auto hit = locator_.nearest(p_O / sum);
  distance = nearest->distance <= 0.0 ? 0.0 : locator_.nearest(nearest->p_O).distance;
  return {near.front().part, std::move(place), hit.point};
}

std::vector<DetectedContact> PosedHandTracker::see(const hand::HandPose& pose,
                                                   const Pose& X_WO) {
  if (!pose.X_WH.matrix().allFinite() || !pose.q.allFinite())
    rejectInput("the demonstrator's pose is not finite");
  if (!X_WO.matrix().allFinite()) rejectInput("the object's pose is not finite");
  hand::LinkPoses X_OL;
  hand::forwardKinematics(*hand_.model, inverse(X_WO) * pose.X_WH, pose.q, X_OL);
  const std::vector<Near> near = nearSamples(X_OL);
  std::vector<char> are_touching(touches_.size(), 0);
  std::vector<DetectedContact> touches;
  for (auto begin = near.begin(); begin != near.end();) {
    const auto end = std::find_if(begin, near.end(), [&](const Near& one) {
      return one.part != begin->part;
    });
    const auto part = static_cast<std::size_t>(begin->part);
    double distance = 0.0;
    DetectedContact touch = middleOf({begin, end}, distance);
    if (distance <= (touches_[part] != 0 ? kEnd : kBegin)) {
      are_touching[part] = 1;
      touches.push_back(std::move(touch));
    }
    begin = end;
  }
  touches_ = std::move(are_touching);
  return touches;
}

std::vector<contact::PartDirection> PosedHandTracker::postureOf(const hand::HandPose& pose,
                                                                const Pose& X_WO) const {
  return shownPosture(turned_,
                      hand_.skin->fromWorld(*hand_.model, {inverse(X_WO) * pose.X_WH, pose.q}));
}

manipulation::ShownHand PosedHandTracker::shownBy(const hand::HandPose& pose,
                                                  const Pose& X_WO) const {
  const Pose X_OH = inverse(X_WO) * pose.X_WH;
  return {postureOf(pose, X_WO), X_OH,
          grip_.at(hand::forwardKinematics(*hand_.model, {X_OH, pose.q}))};
}

}  // namespace handgraft::demonstration
