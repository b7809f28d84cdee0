#pragma once

#include <filesystem>

#include "core/hand/hand_model.h"
#include "core/hand/skin.h"

namespace handgraft::bench {

/// Where built skins are kept unless said otherwise: `handgraft-bench` in XDG_CACHE_HOME, else
/// in the temporary folder.
std::filesystem::path defaultCache();

/// The hand's skin at about `vertex_count` vertices (within 3 %): the edge length is searched
/// for. Kept as a PLY in `cache`, under the hand's path and the count, so that only the first
/// call takes its minute; delete it after changing the wrap.
/// Errors: as readUrdf and buildSkin; InvalidInput if no permitted edge length gives the count.
hand::Skin skinOfSize(const std::filesystem::path& urdf,
                      const hand::HandModel& model,
                      int vertex_count,
                      const std::filesystem::path& cache);

}  // namespace handgraft::bench
