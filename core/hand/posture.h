#pragma once

#include <Eigen/Core>

#include "core/hand/hand_model.h"

namespace handgraft::hand {

/// How a hand stands when nothing asks anything of it, from its own joint ranges alone: a value
/// per dof.
///
/// Joints that close a finger stand a third of the way from straight to closed; all others (at
/// a finger's base, a thumb's opposition, a wrist) in the middle of their range, so that
/// neighbours do not cross. Joints without limits, and all joints of a hand that was given a
/// rest pose, stand at rest. Always within the limits. `q_straight`: fingers straight and
/// spread (Skin::qReference).
/// Cost: as findDigits, linear in the vertices.
Eigen::VectorXd relaxedPosture(const HandModel& model, const Eigen::VectorXd& q_straight);

}  // namespace handgraft::hand
