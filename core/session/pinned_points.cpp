#include "core/session/pinned_points.h"

#include <algorithm>

#include "core/base/error.h"
#include "core/base/pose.h"
#include "core/contact/contact_set.h"
#include "core/optimize/drag.h"
#include "core/session/edit_checks.h"

namespace handgraft::session {

std::vector<std::string> heldLinks(const Document& document) {
  std::vector<std::string> links;
  for (const PinnedPoint& place : document.held)
    links.push_back(place.link);
  return links;
}

bool letGo(Document& document, const std::string& link) {
  return std::erase_if(document.held, [&](const PinnedPoint& place) {
           return place.link == link;
         }) > 0;
}

void validate(const PinnedPoint& place, const hand::HandModel& model) {
  (void)model.linkIndex(place.link);
  const std::string what = "held place of link " + quoted(place.link);
  for (const Eigen::Vector3d& p : {place.p_L, place.target_W}) {
    for (const double value : p)
      requireWithin(value, -kLargestPosition, kLargestPosition, what);
  }
  if (place.target_R_WL) {
    Pose X = Pose::Identity();
    X.linear() = *place.target_R_WL;
    requireRigid(X, what.c_str());
  }
  requireWithin(place.weight, 0.0, contact::kLargestWeight, "weight of the " + what);
}

void addHeldPlaces(const std::vector<PinnedPoint>& held, optimize::PoseProblem& problem) {
  double of_patches = 0.0;
  for (const optimize::PointPair& pair : problem.pairs)
    of_patches += pair.weight;
  for (const PinnedPoint& place : held) {
    optimize::DragTarget target;
    target.link = problem.model->linkIndex(place.link);
    target.p_L = place.p_L;
    target.target_W = place.target_W;
    target.R_WL = place.target_R_WL;
    for (optimize::PointPair& pair :
         optimize::pairsOf(target, kHeldFirmness * place.weight * of_patches))
      problem.pairs.push_back(pair);
  }
}

HeldFit fitOf(const PinnedPoint& place,
              const hand::HandModel& model,
              const hand::HandPose& pose) {
  const int link = model.linkIndex(place.link);
  const Pose X_WL = hand::forwardKinematics(model, pose)[static_cast<std::size_t>(link)];
  HeldFit fit;
  fit.p_W = X_WL * place.p_L;
  fit.off_m = (fit.p_W - place.target_W).norm();
  if (place.target_R_WL)
    fit.off_rad = vectorFromRotation(X_WL.linear().transpose() * *place.target_R_WL).norm();
  return fit;
}

}  // namespace handgraft::session
