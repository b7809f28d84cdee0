#pragma once

#include <filesystem>

#include "core/hand/hand_model.h"

namespace handgraft::bench {

/// The Allegro hand of the recorded sequences: bodies and hinges of its MJCF, ranges of their
/// classes from the template beside it. The free root is left out: link 0 is the wrist.
/// Surfaces come from `meshes`, a folder that has the maker's meshes; links have none without.
/// Errors: InvalidInput naming the file and what is missing.
hand::HandModel readAllegroMjcf(const std::filesystem::path& folder,
                                const std::filesystem::path& meshes);

}  // namespace handgraft::bench
