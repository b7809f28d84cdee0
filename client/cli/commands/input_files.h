#pragma once

#include <optional>
#include <string>
#include <vector>

#include "client/link/model_files.h"
#include "client/present/output_file.h"

namespace handgraft::client {

/// The model's files, as an option or argument named them. Not `sites.yaml`: writing it anew is
/// what it is for.
std::vector<NamedFile> inputsOf(const std::optional<ModelFiles>& model,
                                const std::string& option);

}  // namespace handgraft::client
