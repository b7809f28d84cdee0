#pragma once

#include <random>
#include <string>
#include <vector>

#include "idl/edits.h"
#include "idl/models.h"
#include "idl/sessions.h"

namespace handgraft::bench {

/// Edits as a user's hand makes them, one after another about one grasp: places on object and
/// hand a few millimetres off, turns of some degrees, limits, locks, weights, small moves of
/// the object and of the pose. The same seed gives the same edits.
class RandomEdits {
 public:
  /// `placed` holds the patches as they lie at first; meshes in the order of their faces.
  RandomEdits(unsigned seed,
              const std::vector<v1::PatchReport>& placed,
              const v1::ContactsDescription& contacts,
              const v1::Mesh& object_O,
              const v1::Mesh& skin_S,
              const std::vector<v1::JointInfo>& joints);

  v1::EditBody next();

  /// Of the edit made last: "root on the hand", ...
  [[nodiscard]] const std::string& kind() const { return kind_; }

 private:
  struct Patch {
    std::string name;
    std::vector<long> near_O;  ///< faces within a few millimetres of its root
    std::vector<long> near_S;
  };

  double uniform(double low, double high);
  v1::SurfacePoint placeIn(const std::vector<long>& faces);

  std::mt19937 random_;
  std::vector<Patch> patches_;
  std::vector<v1::JointInfo> joints_;
  std::vector<int> locked_;
  std::string kind_;
};

}  // namespace handgraft::bench
