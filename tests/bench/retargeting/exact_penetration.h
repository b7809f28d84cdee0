#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "core/base/pose.h"
#include "core/hand/hand_model.h"
#include "core/hand/kinematics.h"

#include "tests/bench/retargeting/exact_solid.h"

namespace handgraft::bench {

/// The solids of a hand's links: each link's own shapes, wrapped tightly from outside, so that
/// shells, soups and screws inside count as solid.
class ExactHand {
 public:
  struct Link {
    int link = -1;
    std::shared_ptr<const ExactSolid> solid_L;
    std::vector<Eigen::Vector3d> cells_L;  ///< for the volume
  };

  /// `cache` keeps the wraps. Errors: as hand::wrapped. Cost: some seconds the first time.
  ExactHand(std::shared_ptr<const hand::HandModel> model, const std::filesystem::path& cache);

  [[nodiscard]] const hand::HandModel& model() const { return *model_; }

  [[nodiscard]] const std::vector<Link>& links() const { return links_; }

  /// Pairs of entries of `links` that may not meet: at least two movable joints apart that are
  /// not in one place (10 mm), and not inside one another by 0.5 mm at the rest pose.
  [[nodiscard]] const std::vector<std::array<int, 2>>& collisionPairs() const {
    return collision_pairs_;
  }

 private:
  void findCollisionPairs();

  std::shared_ptr<const hand::HandModel> model_;
  std::vector<Link> links_;
  std::vector<std::array<int, 2>> collision_pairs_;
};

/// How far a posed hand lies inside an object and in itself, by samples 1 mm apart (object) and
/// 1.5 mm apart (hand) and exact distances from them.
struct ExactPenetration {
  static constexpr double kObjectSpacing = 0.001;  // m
  static constexpr double kHandSpacing = 0.0015;   // m
  static constexpr double kCell = 0.002;           // m

  double hand_in_object_m = 0.0;  ///< deepest place of the hand's surface in the object
  /// Deepest place of the object's surface in a link: what tells on walls thinner than a
  /// finger.
  double object_in_hand_m = 0.0;
  int deepest_link = -1;
  double volume_m3 = 0.0;  ///< of the hand inside the object; 0 of an open mesh
  double self_m = 0.0;
  std::array<int, 2> self_links = {-1, -1};

  [[nodiscard]] double deepest() const;
};

/// Frames: the object and X_WH in one frame. Cost: some 50 ms.
ExactPenetration measureExactly(const ExactHand& hand,
                                const ExactSolid& object_W,
                                const hand::HandPose& pose);

}  // namespace handgraft::bench
