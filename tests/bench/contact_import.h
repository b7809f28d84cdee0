#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace handgraft::bench {

/// What became of one contact map by default options, with the joints of the hand that touched
/// where the map itself does not name fingers.
struct ContactImport {
  std::string name;
  std::string refused;  ///< why it could not be read; the rest is empty then
  /// Fingers that touch: parts whose labels are in contact over the minimum area, or, without
  /// labels, parts of which joints say so.
  std::vector<std::string> touching;
  std::vector<std::string> patches;  ///< names, of default segmentation
  int without_help = 0;              ///< patches by the map alone
  /// Patches whose centre is nearest to a joint of the finger they are named for, palm
  /// and wrist counting as one, of those that were compared.
  int confirmed = 0;
  int compared = 0;
  int points = 0;                ///< of interpolation boundaries
  double off_boundary_mm = 0.0;  ///< the farthest of them from its patch's boundary
  double area_mm2 = 0.0;         ///< of all patches, on the mean
  std::vector<std::string> notes;
};

/// Reads and splits one map, a PLY.
ContactImport importContacts(const std::filesystem::path& map);

/// Every file called *_contact.ply below the folders, by path.
std::vector<std::filesystem::path> contactMapsIn(const std::vector<std::string>& folders);

}  // namespace handgraft::bench
