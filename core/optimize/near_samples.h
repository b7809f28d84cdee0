#pragma once

#include <array>
#include <limits>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "core/base/pose.h"
#include "core/geometry/distance_grid.h"
#include "core/geometry/solid.h"
#include "core/hand/hand_solid.h"

namespace handgraft::optimize {

/// How far points of a ball have moved at most between two poses of it, m.
double motionOf(const Pose& from, const Pose& to, const Eigen::Vector3d& centre, double radius);

/// The samples of a set A that may lie in a solid B, kept while A and B move little past each
/// other: searches go by tenths of a millimetre, and most samples are millimetres off.
///
/// What `visit` finds is what looking at every sample finds, whatever was visited before: a
/// sample is left out only while it cannot have come so far. Frames: X_BA takes points of A to
/// B.
class NearSamples {
 public:
  struct Sample {
    Eigen::Vector3d p_A = Eigen::Vector3d::Zero();
    double area_m2 = 0.0;
    double clearance = 0.0;  ///< m; out while no point has moved so far from `reference`
  };

  /// How far the list reaches, and what a sample must be under to be visited: what `grid_B`
  /// says of it is below `threshold`.
  struct Query {
    const geometry::DistanceGrid& grid_B;
    double threshold = 0.0;             ///< m
    Eigen::Vector3d centre_A{0, 0, 0};  ///< of a ball that holds what of A can be in B
    double radius = 0.0;
  };

  /// Calls `visit(sample, p_B, distance, slope_B)` for those under the threshold, in the order
  /// of `gather(passes, take)`, which is called where the list no longer holds: it calls
  /// `take(p_A, area_m2)` for all samples in no ball that `passes(centre_A, radius)`.
  template <class Gather, class Visit>
  void visit(const Query& query, const Pose& X_BA, const Gather& gather, const Visit& visit);

  /// As if nothing had been visited yet.
  void forget() {
    reach_ = -1.0;
    is_known_ = false;
  }

 private:
  /// Of lists that are made while A moves little; where it moves much a list serves once.
  static constexpr double kReach = 0.002;  // m

  double reach_ = -1.0;  ///< m; below 0: no list
  bool is_known_ = false;
  Pose reference_;  ///< where the list was made
  Pose last_;       ///< where `visit` was last
  std::vector<Sample> near_;
};

template <class Gather, class Visit>
void NearSamples::visit(const Query& query,
                        const Pose& X_BA,
                        const Gather& gather,
                        const Visit& visit) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const auto motion_since = [&](const Pose& before) {
    return motionOf(before, X_BA, query.centre_A, query.radius);
  };
  double moved = reach_ < 0.0 ? kInfinity : motion_since(reference_);
  const Eigen::Matrix3d R_BA = X_BA.linear();
  const Eigen::Vector3d p_BA = X_BA.translation();
  const geometry::DistanceGrid& grid_B = query.grid_B;
  if (!(moved <= reach_)) {
    reach_ = is_known_ && motion_since(last_) > kReach ? 0.0 : kReach;
    reference_ = X_BA;
    moved = 0.0;
    near_.clear();
    const double reach = reach_ + query.threshold;
    gather(
        [&](const Eigen::Vector3d& centre_A, double radius) {
          return grid_B.isClear(p_BA + R_BA.lazyProduct(centre_A), radius + reach);
        },
        [&](const Eigen::Vector3d& p_A, double area_m2) {
          const double clearance =
              grid_B.clearance(p_BA + R_BA.lazyProduct(p_A), query.threshold, reach_);
          if (clearance <= reach_) near_.push_back({p_A, area_m2, clearance});
        });
  }
  last_ = X_BA;
  is_known_ = true;
  Eigen::Vector3d slope_B;
  for (const Sample& sample : near_) {
    if (sample.clearance > moved) continue;
    const Eigen::Vector3d p_B = p_BA + R_BA.lazyProduct(sample.p_A);
    const double distance = grid_B.at(p_B, slope_B);
    if (distance < query.threshold) visit(sample, p_B, distance, slope_B);
  }
}

/// All lists of a hand in an object and in itself, of one that moves little.
struct NearLists {
  /// What they are of: they say nothing of anything else.
  struct Source {
    std::shared_ptr<const hand::HandSolid> hand;
    std::shared_ptr<const geometry::Solid> object_O;
    double margin_m = 0.0;
    double self_margin_m = 0.0;
    bool fine = true;  ///< of all samples

    bool operator==(const Source&) const = default;
  };

  Source source;
  std::vector<NearSamples> in_object;  ///< a link's samples
  std::vector<NearSamples> of_walls;   ///< the object's, a link
  /// Each one's in the other, a pair of links; none yet for those that have always been apart.
  std::vector<std::unique_ptr<std::array<NearSamples, 2>>> of_pairs;

  /// Keeps what they know of the same, and nothing of anything else.
  void startFor(const Source& now);
};

}  // namespace handgraft::optimize
