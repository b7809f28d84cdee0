#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/contact/contact_set.h"
#include "core/geometry/triangle_mesh.h"
#include "core/quality/penetration.h"
#include "core/session/session.h"

namespace handgraft::bench {

/// Human contact on an object, as its files give it.
struct ScannedGrasp {
  std::string name;
  std::shared_ptr<const geometry::TriangleMesh> object_O;
  contact::ContactSet contacts;
};

/// `with_joints` gives the splitting of a map the recorded joints of the hand, where there are
/// any (recorded_joints.h). Errors: as io::readMesh and io::readContacts.
ScannedGrasp readGrasp(const std::string& name,
                       const std::filesystem::path& object,
                       const std::filesystem::path& contacts,
                       bool with_joints);

/// A hand as the server makes it of a URDF alone: default skin, sites found. Sites and skins
/// come from nothing that a user wrote. `cache` holds skins made before. Errors: as
/// io::readUrdf and hand::buildSkin; InvalidInput if no site is found.
hand::Hand readHand(const std::filesystem::path& urdf, const std::filesystem::path& cache);

/// What became of one patch.
struct PatchOutcome {
  std::string name;
  std::string site;     ///< it was laid on; empty if it was dropped
  std::string dropped;  ///< why
  int points = 0;
  int lost = 0;
  double mean_mm = 0.0;
  double normal_deg = 0.0;
};

/// What became of a grasp, by all defaults.
struct ChainOutcome {
  std::string hand;
  std::string grasp;
  std::string refused;  ///< why there is no pose; the rest is empty then
  std::vector<PatchOutcome> patches;
  double mean_mm = 0.0;     ///< distance of the points on hand and object, over all of them
  double normal_deg = 0.0;  ///< between n_hand and -n_object
  /// Root of the mean square depth of the hand's skin inside the object.
  double depth_mm = 0.0;
  quality::Penetration penetration;
  double ms_penetration = 0.0;  ///< to measure it, the solids made before
  double objective = 0.0;
  std::string outcome;
  int joints_at_limits = 0;
  // Processor time: matching and laying patches with the search for open directions; the solve.
  double ms_transfer = 0.0;
  double ms_solve = 0.0;
  std::vector<std::string> notes;

  [[nodiscard]] int points() const;
  [[nodiscard]] int lost() const;
  /// The patch that lies farthest from its place; null if none was laid.
  [[nodiscard]] const PatchOutcome* worst() const;
};

/// Opens a session, lays the patches and solves, as `handgraft grasp` does without options or
/// with `--touch-only`.
ChainOutcome graspWith(const hand::Hand& hand,
                       const ScannedGrasp& grasp,
                       bool avoid_penetration);

}  // namespace handgraft::bench
