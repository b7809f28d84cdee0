#include "tests/bench/retargeting/grasp_measure.h"

#include <algorithm>
#include <limits>

#include "core/optimize/diagnosis.h"
#include "core/optimize/solve_report.h"

namespace handgraft::bench {

namespace {

/// To the nearest link of a part, m.
double distanceTo(const std::string& part,
                  const ExactHand& hand,
                  const std::vector<std::string>& parts,
                  const hand::LinkPoses& X_WL,
                  const Eigen::Vector3d& p_W) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const ExactHand::Link& link : hand.links()) {
    const auto index = static_cast<std::size_t>(link.link);
    if (parts[index] != part) continue;
    nearest = std::min(nearest, link.solid_L->distance(inverse(X_WL[index]) * p_W));
  }
  return nearest;
}

}  // namespace

GraspMeasure measureGrasp(const optimize::PoseProblem& problem,
                          const ExactHand& hand,
                          const std::vector<std::string>& parts,
                          const ExactSolid& object_W,
                          const hand::HandPose& pose) {
  optimize::SolveReport report;
  report.pose = pose;
  report.patches = optimize::fitPatches(problem, pose);
  const std::vector<double> facing = optimize::facingAngles(problem, report);
  const hand::LinkPoses X_WL = hand::forwardKinematics(hand.model(), pose);

  GraspMeasure measure;
  double points = 0.0;
  for (std::size_t k = 0; k < report.patches.size(); ++k) {
    const optimize::PatchFit& fit = report.patches[k];
    PatchMeasure patch;
    patch.patch = fit.patch;
    patch.mean_mm = fit.mean_mm;
    patch.facing_deg = facing[k];
    for (const optimize::PointPair& pair : problem.pairs) {
      if (pair.patch != fit.patch) continue;
      const std::string& part = parts[static_cast<std::size_t>(pair.link)];
      patch.gap_mm += 1e3 * distanceTo(part, hand, parts, X_WL, pair.p_W) / fit.point_count;
    }
    patch.reached = patch.mean_mm <= kReachedMm && patch.facing_deg <= kFacingDeg;
    measure.reached += patch.reached ? 1 : 0;
    measure.mean_mm += patch.mean_mm * fit.point_count;
    measure.facing_deg += patch.facing_deg * fit.point_count;
    measure.gap_mm += patch.gap_mm * fit.point_count;
    points += fit.point_count;
    measure.patches.push_back(patch);
  }
  points = std::max(points, 1.0);
  measure.mean_mm /= points;
  measure.facing_deg /= points;
  measure.gap_mm /= points;
  measure.penetration = measureExactly(hand, object_W, pose);
  return measure;
}

}  // namespace handgraft::bench
