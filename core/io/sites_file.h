#pragma once

#include <filesystem>
#include <vector>

#include "core/hand/contact_site.h"

namespace handgraft::io {

/// Reads a hand's contact sites (YAML; README of this folder). Errors: InvalidInput naming the
/// file, the site and the field.
std::vector<hand::ContactSite> readSites(const std::filesystem::path& path,
                                         const hand::HandModel& model);

}  // namespace handgraft::io
