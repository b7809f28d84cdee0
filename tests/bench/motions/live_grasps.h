#pragma once

#include <filesystem>
#include <vector>

#include "core/hand/hand.h"

namespace handgraft::bench {

/// Recorded grasps followed live, two of each object: the demonstrator's fingers close from
/// flat within 0.4 s and hold for 0.8 s, in which the object is lifted by 0.1 m. A row a hand,
/// as of `printLiveRow`, for all of them together.
///
/// `data`: the folder of contacts, hands and objects. Errors: InvalidInput naming what cannot
/// be read; grasps that touch nothing are left out. `pictures`: folder for one a hand and
/// grasp, as of `drawLiveGrasp`; empty: none.
void runLiveGrasps(const std::filesystem::path& data,
                   const std::filesystem::path& cache,
                   const std::vector<hand::Hand>& hands,
                   const std::filesystem::path& pictures);

}  // namespace handgraft::bench
