#pragma once

#include <filesystem>
#include <map>
#include <string>

namespace handgraft::bench {

/// Best known objective of each problem that a folder holds and its `reference.json` names.
/// Errors: InvalidInput if there is none.
std::map<std::string, double> readBestKnown(const std::filesystem::path& directory);

/// The hand's URDF that a problem file names. Errors: InvalidInput.
std::filesystem::path urdfOf(const std::filesystem::path& problem_file);

}  // namespace handgraft::bench
