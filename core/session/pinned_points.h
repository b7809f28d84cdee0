#pragma once

#include <string>
#include <vector>

#include "core/optimize/pose_problem.h"
#include "core/session/document.h"

namespace handgraft::session {

/// Of a held place, as many times as firm as all patches together.
inline constexpr double kHeldFirmness = 20.0;

/// The links that are held, in the order of their drags.
std::vector<std::string> heldLinks(const Document& document);

/// Lets go the place of a link; false if none is held.
bool letGo(Document& document, const std::string& link);

/// Errors: InvalidInput naming the link and what is wrong.
void validate(const PinnedPoint& place, const hand::HandModel& model);

/// Adds the places to a problem that has its patches: pairs of no patch, without normals.
///
/// All pairs of one place weigh `weight` times twenty times as much as all patches together,
/// so that patches which pull at it move it by a twentieth of what they miss by, at most.
void addHeldPlaces(const std::vector<PinnedPoint>& held, optimize::PoseProblem& problem);

/// Where a pose has a held place.
struct HeldFit {
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();
  double off_m = 0.0;    ///< from its target
  double off_rad = 0.0;  ///< from its rotation; 0 where that is free
};

/// Errors: BrokenContract for a link that the hand lacks.
HeldFit fitOf(const PinnedPoint& place,
              const hand::HandModel& model,
              const hand::HandPose& pose);

}  // namespace handgraft::session
