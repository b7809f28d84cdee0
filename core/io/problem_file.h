#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "core/optimize/pose_problem.h"

namespace handgraft::io {

/// A problem and the order in which its file lists the degrees of freedom.
struct ProblemFile {
  optimize::PoseProblem problem;
  /// Entry i of the file's `dofs` is degree of freedom order[i] of the problem.
  std::vector<int> order;
};

/// Reads `handgraft-problem/1` (README of this folder). The hand's URDF is found beside the
/// file; only its kinematics is read. Points and normals are taken as they are written. Errors:
/// InvalidInput naming the file and the field.
ProblemFile readProblemFile(const std::filesystem::path& path);

/// The problem alone.
optimize::PoseProblem readProblem(const std::filesystem::path& path);

/// The text of a problem file, exact: doubles are written so that reading gives the same bits;
/// only the root's rotations pass through a rotation vector, which costs a rounding.
/// `notes` are for people, such as what else was asked of the solve that no file can say.
/// Errors: InvalidInput if the problem is not valid (a NaN has no spelling in JSON).
std::string problemText(const optimize::PoseProblem& problem,
                        const std::string& urdf_path,
                        const std::vector<std::pair<std::string, std::string>>& packages,
                        const std::vector<std::string>& notes = {});

/// theta in the order of `problemText`: root_rx, root_ry, root_rz, root_tx, root_ty, root_tz,
/// joints. The rotation vector's angle lies in [0, pi].
Eigen::VectorXd thetaOf(const hand::HandPose& pose);

}  // namespace handgraft::io
