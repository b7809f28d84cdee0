#pragma once

#include <string>
#include <vector>

#include "tests/bench/retargeting/retargeted_grasp.h"

namespace handgraft::bench {

/// How one way of retargeting did over some grasps. Millimetres, degrees, cm3, milliseconds.
struct MethodSummary {
  std::string method;
  int grasps = 0;
  int asked = 0;    ///< patches
  int reached = 0;  ///< of them
  int whole = 0;    ///< grasps whose patches were all reached
  // Means over the grasps.
  double mean_mm = 0.0;
  double facing_deg = 0.0;
  double gap_mm = 0.0;
  double shared_cm3 = 0.0;
  // The deepest place between hand and object, a figure a grasp.
  double deepest_median_mm = 0.0;
  double deepest_worst_mm = 0.0;
  int past_2mm = 0;  ///< grasps
  double self_median_mm = 0.0;
  double self_worst_mm = 0.0;
  double solve_median_ms = 0.0;
  double solve_p95_ms = 0.0;
};

struct HandSummary {
  std::string hand;
  int dofs = 0;
  int refused = 0;
  int dropped = 0;  ///< patches that the hand cannot have
  MethodSummary ours;
  /// From the models to the pose: what is tried while patches are laid need not be solved
  /// again.
  double pose_median_ms = 0.0;
  double pose_p95_ms = 0.0;
  double transfer_median_ms = 0.0;
  double transfer_p95_ms = 0.0;
  double told_median_mm = 0.0;  ///< deepest place as the product tells it
  double told_worst_mm = 0.0;
  /// Joints from the demonstrator's, median over the grasps with four touching digits and
  /// more, and over all; NaN on other hands.
  double joints_four_mm = 0.0;
  double joints_all_mm = 0.0;
  std::vector<MethodSummary> baselines;
};

/// `name` stands for the hands that `grasps` are of.
HandSummary summarise(const std::string& name,
                      int dofs,
                      const std::vector<const RetargetedGrasp*>& grasps);

/// Two tables: ours with all figures, and beside the baselines.
std::string markdownOf(const std::vector<HandSummary>& hands);

/// A row a grasp, and the summaries; one JSON document.
std::string jsonOf(const std::vector<HandSummary>& hands,
                   const std::vector<RetargetedGrasp>& grasps);

}  // namespace handgraft::bench
