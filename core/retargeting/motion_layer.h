#pragma once

#include <compare>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include <Eigen/Core>

#include "core/base/progress.h"
#include "core/hand/finger_coordinates.h"
#include "core/manipulation/transfer_patches.h"
#include "core/session/document.h"
#include "core/session/models.h"

/// How a motion's patches lie on a hand, and where edits at times move them.
namespace handgraft::retargeting {

/// How far a patch is from where the motion has it, about its own root and direction there.
struct Shift {
  Eigen::Vector2d way_T = Eigen::Vector2d::Zero();
  double turn_rad = 0.0;

  [[nodiscard]] bool isNone() const { return way_T.isZero() && turn_rad == 0.0; }

  /// A share of the way to another one.
  void go(const Shift& to, double share) {
    way_T += share * (to.way_T - way_T);
    turn_rad += share * (to.turn_rad - turn_rad);
  }

  auto operator<=>(const Shift& other) const {
    return std::tuple(way_T.x(), way_T.y(), turn_rad) <=>
           std::tuple(other.way_T.x(), other.way_T.y(), other.turn_rad);
  }
};

struct Shifts {
  Shift on_object;
  Shift on_hand;

  [[nodiscard]] bool isNone() const { return on_object.isNone() && on_hand.isNone(); }

  auto operator<=>(const Shifts& other) const {
    return std::tie(on_object, on_hand) <=> std::tie(other.on_object, other.on_hand);
  }
};

contact::Patch withDirection(const geometry::TriangleMesh& mesh, contact::Patch patch);

/// Log coordinates of `to` about `from`, x along `direction`.
/// Errors: InvalidInput naming the patch if no way over the surface leads there.
Eigen::Vector2d wayTo(const geometry::TriangleMesh& mesh,
                      const geometry::SurfacePoint& from,
                      const Eigen::Vector3d& direction,
                      const geometry::SurfacePoint& to,
                      const std::string& patch);

/// A key's patch, moved over the object.
contact::Patch movedOver(const geometry::TriangleMesh& object_O,
                         const contact::Patch& patch,
                         const Shift& shift);

/// Lays patches of a motion onto a hand, as a whole or one key at a time.
class MotionLayer {
 public:
  /// All of them outlive it, but for `motion`.
  MotionLayer(const session::Document& document,
              const hand::Hand& hand,
              const geometry::TriangleMesh& object_O,
              const manipulation::Motion& motion);

  [[nodiscard]] manipulation::TransferredMotion lay(
      const manipulation::Motion& motion,
      const Progress& progress,
      const manipulation::MovePlacement& move = {},
      manipulation::MotionCharts* charts = nullptr) const;

  /// The pairs of one key of a track, its patch moved on both sides.
  /// Errors: InvalidInput naming the patch if it cannot be moved so on the hand.
  [[nodiscard]] std::vector<optimize::PointPair> layKey(const manipulation::Motion& motion,
                                                        int track,
                                                        const manipulation::PatchKey& key,
                                                        const Shifts& shifts,
                                                        const Progress& progress) const;

  /// Where a key's patch goes on the hand as the motion has it.
  [[nodiscard]] std::optional<transfer::PatchPlacement> placementOf(
      const manipulation::PatchKey& key) const;

 private:
  const session::Document& document_;
  const hand::Hand& hand_;
  const geometry::TriangleMesh& object_O_;
  hand::FingerCoordinates coordinates_;
  transfer::Surfaces surfaces_;
  bool lies_on_links_;
  bool has_points_;
};

}  // namespace handgraft::retargeting
