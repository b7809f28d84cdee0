#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/contact/contact_set.h"
#include "core/geometry/triangle_mesh.h"
#include "core/hand/kinematics.h"
#include "core/session/models.h"

#include "tests/bench/retargeting/exact_solid.h"

namespace handgraft::bench {

/// An object that somebody grasped, measured exactly.
struct GraspedObject {
  std::string name;
  std::shared_ptr<const geometry::TriangleMesh> mesh_O;
  std::shared_ptr<const ExactSolid> solid_O;
};

/// A human grasp: a posed hand, and what it touches. The object stands in the world's origin,
/// so that O and W are one.
struct Demonstration {
  std::string name;  ///< "025_mug/3": object, and number of its grasp in the file
  const GraspedObject* object = nullptr;
  hand::HandPose pose;  ///< of the demonstrator
  contact::ContactSet contacts;
  int digits_touching = 0;  ///< the palm left out
};

/// Grasps of one hand on several objects, as a file has them:
/// { "qpos_joint_names": [...], "grasps": { OBJECT: [ { "qpos": [...],
/// "object_pose_xyz_qwxyz": [7] } ... ] } }.
class DemonstrationFile {
 public:
  /// `objects`: folders that have OBJECT.obj (stl, ply, glb), or have folders that do. Objects
  /// without a mesh are left out. Errors: InvalidInput naming file and fault.
  DemonstrationFile(const std::filesystem::path& grasps,
                    const std::vector<std::filesystem::path>& objects);

  /// File name of the demonstrator's URDF.
  [[nodiscard]] const std::string& handFile() const { return hand_file_; }

  [[nodiscard]] const std::vector<std::shared_ptr<const GraspedObject>>& objects() const {
    return objects_;
  }

  /// A grasp that is not read yet.
  struct Entry {
    const GraspedObject* object = nullptr;
    int number = 0;
    std::vector<double> qpos;
    Pose X_WO = Pose::Identity();

    [[nodiscard]] std::string name() const;
  };

  [[nodiscard]] const std::vector<Entry>& entries() const { return entries_; }

  /// `per_object` grasps of each object, drawn by `seed`; all of them for 0.
  [[nodiscard]] std::vector<Entry> draw(int per_object, unsigned seed) const;

  /// Poses the hand and takes what it touches. `carrier`: the joints that place it, cut off.
  /// Errors: InvalidInput if a joint is unknown or the hand touches nothing.
  [[nodiscard]] Demonstration read(const Entry& entry,
                                   const hand::Hand& hand,
                                   const hand::HandModel* carrier) const;

 private:
  std::string hand_file_;
  std::vector<std::string> joints_;
  std::vector<std::shared_ptr<const GraspedObject>> objects_;
  std::vector<Entry> entries_;
};

}  // namespace handgraft::bench
