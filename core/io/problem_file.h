#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/optimize/pose_problem.h"

namespace handgraft::io {

/// Reads `handgraft-problem/1` (README of this folder). The hand's URDF is found beside the file;
/// only its kinematics is read.
/// Errors: InvalidInput naming the file and the field.
optimize::PoseProblem readProblem(const std::filesystem::path& path);

/// The text of a problem file, exact: doubles are written so that reading gives the same bits.
std::string problemText(const optimize::PoseProblem& problem,
                        const std::string& urdf_path,
                        const std::vector<std::pair<std::string, std::string>>& packages);

/// theta in the file's order of dofs: root_rx, root_ry, root_rz, root_tx, root_ty, root_tz, joints.
Eigen::VectorXd thetaOf(const hand::HandPose& pose);

}  // namespace handgraft::io
