#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/base/resource_uri.h"
#include "core/hand/hand_model.h"

namespace handgraft::io {

struct UrdfFile {
  hand::HandModel model;
  /// Joints of the file that place the whole hand, cut off from the model
  /// (hand/floating_base.h).
  std::optional<hand::HandModel> floating_base;
  /// The text as it was read.
  std::string text;
  /// What was amended or left out, for the user: "joint 'x': no limit, taken as +-pi".
  std::vector<std::string> notes;
};

/// Reads a hand from a URDF and its meshes (urdfdom, assimp).
///
/// Frames and units: as URDF has them, metres and radians; mesh scales applied; primitives
/// become
///   meshes. Planar and floating joints become chains of joints of one freedom (urdf_text.h).
/// Errors: InvalidInput, naming the file and the joint, link or mesh, for XML that does not
/// parse
///   (urdfdom's own words are quoted), a missing mesh, a joint loop, what is
///   beyond the limits of this folder's README. Limits that a movable
///   joint lacks are noted, not refused.
UrdfFile readUrdf(const std::filesystem::path& path, const PackageMap& packages = {});

/// As above, with the meshes' files found by `find`; nothing else is opened. Files that the
/// URDF gives no `scale` other than 1 are taken to be in units of `mesh_unit_m` metres.
UrdfFile readUrdf(const std::filesystem::path& path,
                  const ResourceFinder& find,
                  double mesh_unit_m = 1.0);

/// What becomes of joints that place the whole hand.
enum class FloatingBase { kCut, kKept };

/// Joints and links alone, geometry left out: for problem files, whose kinematics is all they
/// need. No mesh has to exist.
hand::HandModel readUrdfKinematics(const std::filesystem::path& path,
                                   FloatingBase floating_base = FloatingBase::kCut);

}  // namespace handgraft::io
