#pragma once

#include <filesystem>

#include <Eigen/Core>

#include "core/hand/hand_model.h"

namespace handgraft::bench {

/// The Allegro hand of the recorded sequences: bodies and hinges of its MJCF, ranges of their
/// classes from the template beside it. The free root is left out: link 0 is the wrist.
/// Surfaces come from `meshes`, a folder that has the maker's meshes; links have none without.
/// Errors: InvalidInput naming the file and what is missing.
hand::HandModel readAllegroMjcf(const std::filesystem::path& folder,
                                const std::filesystem::path& meshes);

/// The human's hand of the recorded sequences: bodies of its MJCF, meshes of its links, ball
/// joints as hinges NAME_x, NAME_y, NAME_z with R = Rx Ry Rz: fingers bend about the last one.
/// `ranges`: of each hinge, lower above upper, since the file has none; they tell which way a
/// finger closes. Link 0 is the wrist, free. Errors: as above.
hand::HandModel readManoMjcf(const std::filesystem::path& folder,
                             const Eigen::Matrix2Xd& ranges);

}  // namespace handgraft::bench
