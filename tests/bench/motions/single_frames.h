#pragma once

#include <memory>
#include <vector>

#include "core/geometry/triangle_mesh.h"
#include "core/hand/skin.h"
#include "core/manipulation/motion_problem.h"

namespace handgraft::bench {

/// What each term of Eq. 2 costs in a motion's frames, each solved alone from `starts` and many
/// others: a table of the mean residual with one term after the other.
void printSingleFrames(const manipulation::MotionProblem& problem,
                       const std::vector<hand::HandPose>& starts,
                       const std::shared_ptr<const hand::Skin>& skin,
                       const std::shared_ptr<const geometry::TriangleMesh>& object_O,
                       std::size_t stride);

}  // namespace handgraft::bench
