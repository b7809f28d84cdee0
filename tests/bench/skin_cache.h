#pragma once

#include <filesystem>

#include "core/hand/hand_model.h"
#include "core/hand/skin.h"

namespace handgraft::bench {

/// Where built skins are kept unless said otherwise: `handgraft-bench` in XDG_CACHE_HOME, else
/// in the temporary folder.
std::filesystem::path defaultCache();

/// The hand's skin at about `vertex_count` vertices (within 3 %): the edge length is searched
/// for. All that is tried is kept in `cache` (hand/skin_cache.h), so that only the first call
/// takes its minute.
/// Errors: as buildSkin; InvalidInput if no permitted edge length gives the count.
hand::Skin skinOfSize(const hand::HandModel& model,
                      int vertex_count,
                      const std::filesystem::path& cache);

}  // namespace handgraft::bench
