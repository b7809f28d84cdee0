#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/hand/contact_site.h"

namespace handgraft::io {

/// Reads a hand's contact sites (YAML; README of this folder). With `mirrored`, the model is
/// the mirror image (hand/mirror.h) of the hand that its URDF describes: sites of a file that
/// does not say `mirrored: true` are the URDF's, and mirrored along; and the other way round.
/// Errors: InvalidInput naming the file, the site and the field.
std::vector<hand::ContactSite> readSites(const std::filesystem::path& path,
                                         const hand::HandModel& model,
                                         bool mirrored = false);

/// The text of such a file, of a mirrored hand if so: comments that say what may be edited,
/// then a line a field. Numbers have 9 digits. What `readSites` makes of it has the same names,
/// links and, to 1e-8, numbers. Requires sites that `hand::validate` accepts.
std::string sitesText(const std::vector<hand::ContactSite>& sites, bool mirrored = false);

/// Writes it to a file. Errors: InvalidInput, naming the file, if it cannot be written.
void writeSites(const std::filesystem::path& path, const std::vector<hand::ContactSite>& sites);

}  // namespace handgraft::io
