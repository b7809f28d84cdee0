#pragma once

#include <filesystem>
#include <string>

namespace handgraft::bench {

enum class HumanWays {
  kAll,       ///< contacts, fingertip kinematics, DexPilot; contacts live
  kContacts,  ///< of these all at once, and live
  kLive,      ///< frame by frame as they come alone, by more hands
};

/// The contact areas of the recorded human hand over time, followed by several hands, beside
/// fingertip kinematics and DexPilot from frame to frame: a row a sequence, a hand and a way.
///
/// The human's hand is posed by its recorded splines, and its areas are cut as
/// session::motionOfPosedHand does. All three ways are measured by the same correspondences.
/// `data`: as for `motions`; `library`: the built-in models, of which human20 follows, too;
/// empty: it does not. `folder`: hands to follow
/// instead; empty: those of the data. `pictures`: as for `runLiveGrasps`. Errors: InvalidInput
/// naming what cannot be read.
void runHumanMotions(const std::filesystem::path& data,
                     const std::filesystem::path& library,
                     const std::filesystem::path& cache,
                     HumanWays ways,
                     const std::filesystem::path& folder,
                     const std::filesystem::path& pictures);

}  // namespace handgraft::bench
