#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/hand/skin_report.h"

namespace handgraft::bench {

/// A site that was found on a hand.
struct FoundSite {
  std::string name;
  std::string link;
  /// Between the site's normal and the way its digit closes; for the palm the way most do. More
  /// than 90 is on the back of the hand.
  double off_closing_deg = 0.0;
  /// To the site of that name in `sites.yaml` beside the URDF; NaN without it.
  double to_given_mm = 0.0;
};

/// What became of one URDF, without any other file but its meshes.
struct HandImport {
  std::string name;
  std::filesystem::path path;
  std::string refused;  ///< why it could not be read; the rest is empty then
  int links = 0;
  int dofs = 0;
  int mimics = 0;
  int root_dofs = 0;  ///< of a free root that was cut off
  std::vector<std::string> notes;
  double read_s = 0.0;
  double pose_difference = 0.0;  ///< from DART (dart_poses.h); NaN if DART cannot tell
  hand::SkinReport skin;
  double skin_s = 0.0;  ///< processor time
  int digits = 0;       ///< fingers and thumb that the kinematics has
  std::vector<FoundSite> sites;

  [[nodiscard]] int sitesOnTheBack() const;
  [[nodiscard]] int pads() const;  ///< sites of digits
};

/// Reads, wraps and measures one hand. `poses` are compared with DART's.
HandImport importHand(const std::filesystem::path& urdf, int poses);

/// Every file called *.urdf below the folders, by path.
std::vector<std::filesystem::path> urdfsIn(const std::vector<std::string>& folders);

}  // namespace handgraft::bench
