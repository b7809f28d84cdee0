#include "core/placement/pregrasp.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/hand/kinematics.h"
#include "core/placement/solids.h"

namespace handgraft::placement {

namespace {

constexpr double kClear = 0.5e-3;  // m
constexpr int kSteps = 10;
constexpr double kNudge = 1e-4;  // rad or m
/// Of how far a joint takes what touches, so much is to lead away from the object.
constexpr double kLeadsAway = 0.05;

/// Each joint at the limit that takes what touches away; as it is where neither does.
Eigen::VectorXd openedOf(const hand::HandModel& model,
                         const hand::HandPose& grasp,
                         const std::vector<optimize::PointPair>& pairs) {
  const hand::LinkPoses X_WL = hand::forwardKinematics(model, grasp);
  Eigen::VectorXd q = grasp.q;
  for (Eigen::Index dof = 0; dof < q.size(); ++dof) {
    hand::HandPose nudged = grasp;
    nudged.q[dof] += kNudge;
    const hand::LinkPoses X_WN = hand::forwardKinematics(model, nudged);
    double away = 0.0;
    double moved = 0.0;
    for (const optimize::PointPair& pair : pairs) {
      if (!pair.has_normals || pair.weight <= 0.0) continue;
      const auto link = static_cast<std::size_t>(pair.link);
      const Eigen::Vector3d way_W = X_WN[link] * pair.p_L - X_WL[link] * pair.p_L;
      away += way_W.dot(pair.n_W);
      moved += way_W.norm();
    }
    if (std::abs(away) <= kLeadsAway * moved) continue;
    const double limit = away > 0.0 ? model.upper()[dof] : model.lower()[dof];
    if (std::isfinite(limit)) q[dof] = limit;
  }
  return q;
}

/// The way from a grasp to other joint values, its root standing still.
class Way {
 public:
  Way(const hand::Hand& hand,
      std::shared_ptr<const geometry::TriangleMesh> object_O,
      hand::HandPose grasp_O,
      const Progress& progress)
      : hand_(hand),
        object_O_(std::move(object_O)),
        grasp_O_(std::move(grasp_O)),
        progress_(progress),
        first_(depthsAt(grasp_O_.q)) {}

  [[nodiscard]] quality::Depths depthsAt(const Eigen::VectorXd& q) const {
    return depthsOf(hand_.model, hand_.skin, object_O_, {grasp_O_.X_WH, q}, progress_);
  }

  /// The last pose on the way to `q` that is clear, before anything is met that was not.
  [[nodiscard]] Pregrasp towards(const Eigen::VectorXd& q) const {
    Pregrasp best{grasp_O_.q, first_.object_m <= kClear, first_.object_m};
    for (int i = 1; i <= kSteps; ++i) {
      const double share = static_cast<double>(i) / kSteps;
      const Eigen::VectorXd there = grasp_O_.q + share * (q - grasp_O_.q);
      const quality::Depths depths = depthsAt(there);
      if (depths.object_m > first_.object_m + kClear || depths.self_m > first_.self_m + kClear)
        break;
      const bool is_clear = depths.object_m <= kClear;
      if (!is_clear && (best.is_clear || depths.object_m >= best.depth_m)) continue;
      best = {there, is_clear, depths.object_m};
    }
    return best;
  }

 private:
  const hand::Hand& hand_;
  std::shared_ptr<const geometry::TriangleMesh> object_O_;
  hand::HandPose grasp_O_;
  const Progress& progress_;
  quality::Depths first_;
};

}  // namespace

Pregrasp pregraspOf(const hand::Hand& hand,
                    const std::shared_ptr<const geometry::TriangleMesh>& object_O,
                    const Pose& X_WO,
                    const hand::HandPose& grasp,
                    const std::vector<optimize::PointPair>& pairs,
                    const Progress& progress) {
  const hand::HandModel& model = *hand.model;
  const Way way(hand, object_O, {inverse(X_WO) * grasp.X_WH, grasp.q}, progress);
  const Pregrasp resting = way.towards(model.restPose());
  if (resting.is_clear && resting.q.isApprox(model.restPose(), 1e-12)) {
    return {model.restPose(), true, resting.depth_m};
  }
  Pregrasp opened = way.towards(openedOf(model, grasp, pairs));
  if (opened.is_clear) return opened;
  return resting.is_clear || resting.depth_m < opened.depth_m ? resting : opened;
}

}  // namespace handgraft::placement
