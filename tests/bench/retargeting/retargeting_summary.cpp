#include "tests/bench/retargeting/retargeting_summary.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include <fmt/format.h>

#include "tests/bench/timing.h"

namespace handgraft::bench {

namespace {

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();

double medianOf(const std::vector<double>& values) {
  return values.empty() ? kNothing : quantile(values, 0.5);
}

double worstOf(const std::vector<double>& values) {
  return values.empty() ? kNothing : quantile(values, 1.0);
}

/// What one method made of a grasp; null where it made nothing.
using Choice = std::function<const Retargeted*(const RetargetedGrasp&)>;

MethodSummary summaryOf(const std::string& method,
                        const std::vector<const RetargetedGrasp*>& grasps,
                        const Choice& choose) {
  MethodSummary summary;
  summary.method = method;
  std::vector<double> deepest;
  std::vector<double> self;
  std::vector<double> times;
  for (const RetargetedGrasp* grasp : grasps) {
    const Retargeted* result = grasp->refused.empty() ? choose(*grasp) : nullptr;
    if (result == nullptr) continue;
    const GraspMeasure& measure = result->measure;
    ++summary.grasps;
    summary.asked += grasp->asked;
    summary.reached += measure.reached;
    summary.whole += measure.reached == grasp->asked ? 1 : 0;
    summary.mean_mm += measure.mean_mm;
    summary.facing_deg += measure.facing_deg;
    summary.gap_mm += measure.gap_mm;
    summary.shared_cm3 += 1e6 * measure.penetration.volume_m3;
    deepest.push_back(1e3 * measure.penetration.deepest());
    summary.past_2mm += deepest.back() > 2.0 ? 1 : 0;
    self.push_back(1e3 * measure.penetration.self_m);
    times.push_back(result->ms);
  }
  const double count = std::max(1, summary.grasps);
  summary.mean_mm /= count;
  summary.facing_deg /= count;
  summary.gap_mm /= count;
  summary.shared_cm3 /= count;
  summary.deepest_median_mm = medianOf(deepest);
  summary.deepest_worst_mm = worstOf(deepest);
  summary.self_median_mm = medianOf(self);
  summary.self_worst_mm = worstOf(self);
  summary.solve_median_ms = medianOf(times);
  summary.solve_p95_ms = times.empty() ? kNothing : quantile(times, 0.95);
  return summary;
}

double percent(int part, int whole) {
  return whole == 0 ? 0.0 : 100.0 * part / whole;
}

std::string numberOr(double value) {
  return std::isnan(value) ? "" : fmt::format("{:.1f}", value);
}

std::string mainTable(const std::vector<HandSummary>& hands) {
  std::string text =
      "| hand | joints | grasps | patches reached | all of them | mean mm | normals deg | gap "
      "mm "
      "| deepest mm: median, worst, past 2 mm | as told: median, worst | shared cm3 | self mm: "
      "median, worst | open ms: median, p95 | solve ms: median, p95 | first pose ms: median, "
      "p95 | "
      "joints off mm: four "
      "digits, "
      "all |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n";
  for (const HandSummary& hand : hands) {
    const MethodSummary& ours = hand.ours;
    text += fmt::format(
        "| {} | {} | {}{} | {:.0f} % of {}{} | {:.0f} % | {:.1f} | {:.0f} | {:.1f} | {:.1f}, "
        "{:.1f}, {:.0f} % | {:.1f}, {:.1f} | {:.2f} | {:.1f}, {:.1f} | {:.0f}, {:.0f} | "
        "{:.0f}, "
        "{:.0f} | {:.0f}, {:.0f} | {} |\n",
        hand.hand, hand.dofs == 0 ? "" : std::to_string(hand.dofs), ours.grasps,
        hand.refused == 0 ? "" : fmt::format(", {} refused", hand.refused),
        percent(ours.reached, ours.asked), ours.asked,
        hand.dropped == 0 ? "" : fmt::format(", {} dropped", hand.dropped),
        percent(ours.whole, ours.grasps), ours.mean_mm, ours.facing_deg, ours.gap_mm,
        ours.deepest_median_mm, ours.deepest_worst_mm, percent(ours.past_2mm, ours.grasps),
        hand.told_median_mm, hand.told_worst_mm, ours.shared_cm3, ours.self_median_mm,
        ours.self_worst_mm, hand.transfer_median_ms, hand.transfer_p95_ms, ours.solve_median_ms,
        ours.solve_p95_ms, hand.pose_median_ms, hand.pose_p95_ms,
        std::isnan(hand.joints_all_mm)
            ? ""
            : numberOr(hand.joints_four_mm) + ", " + numberOr(hand.joints_all_mm));
  }
  return text;
}

void addMethod(const std::string& hand, const MethodSummary& method, std::string& text) {
  if (method.grasps == 0) return;
  text += fmt::format(
      "| {} | {} | {} | {:.0f} % | {:.1f} | {:.0f} | {:.1f} | {:.1f}, {:.1f}, {:.0f} % | "
      "{:.2f} | "
      "{:.1f} | {:.0f}, {:.0f} |\n",
      hand, method.method, method.grasps, percent(method.reached, method.asked), method.mean_mm,
      method.facing_deg, method.gap_mm, method.deepest_median_mm, method.deepest_worst_mm,
      percent(method.past_2mm, method.grasps), method.shared_cm3, method.self_median_mm,
      method.solve_median_ms, method.solve_p95_ms);
}

std::string baselineTable(const std::vector<HandSummary>& hands) {
  std::string text =
      "| hand | way | grasps | patches reached | mean mm | normals deg | gap mm | deepest mm: "
      "median, worst, past 2 mm | shared cm3 | self mm | solve ms: median, p95 |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|\n";
  for (const HandSummary& hand : hands) {
    addMethod(hand.hand, hand.ours, text);
    for (const MethodSummary& method : hand.baselines)
      addMethod(hand.hand, method, text);
  }
  return text;
}

}  // namespace

HandSummary summarise(const std::string& name,
                      int dofs,
                      const std::vector<const RetargetedGrasp*>& grasps) {
  HandSummary summary;
  summary.hand = name;
  summary.dofs = dofs;
  summary.ours = summaryOf("contact transfer", grasps, [](const RetargetedGrasp& grasp) {
    return &grasp.ours;
  });
  const auto maybe = [](const std::optional<Retargeted>& result) {
    return result ? &*result : nullptr;
  };
  summary.baselines.push_back(
      summaryOf("fingertip kinematics", grasps, [&](const RetargetedGrasp& grasp) {
        return maybe(grasp.fingertips);
      }));
  summary.baselines.push_back(summaryOf("DexPilot", grasps, [&](const RetargetedGrasp& grasp) {
    return maybe(grasp.dex_pilot);
  }));
  std::vector<double> transfers;
  std::vector<double> poses;
  std::vector<double> told;
  std::vector<double> joints;
  std::vector<double> joints_of_four;
  for (const RetargetedGrasp* grasp : grasps) {
    if (!grasp->refused.empty()) {
      ++summary.refused;
      continue;
    }
    summary.dropped += static_cast<int>(grasp->patches.size()) - grasp->asked;
    transfers.push_back(grasp->ms_transfer);
    poses.push_back(grasp->ms_pose);
    told.push_back(1e3 * grasp->told_depth_m);
    if (!grasp->joints_mm) continue;
    joints.push_back(*grasp->joints_mm);
    if (grasp->digits_touching >= 4) joints_of_four.push_back(*grasp->joints_mm);
  }
  summary.transfer_median_ms = medianOf(transfers);
  summary.transfer_p95_ms = transfers.empty() ? kNothing : quantile(transfers, 0.95);
  summary.pose_median_ms = medianOf(poses);
  summary.pose_p95_ms = poses.empty() ? kNothing : quantile(poses, 0.95);
  summary.told_median_mm = medianOf(told);
  summary.told_worst_mm = worstOf(told);
  summary.joints_four_mm = medianOf(joints_of_four);
  summary.joints_all_mm = medianOf(joints);
  return summary;
}

std::string markdownOf(const std::vector<HandSummary>& hands) {
  std::string text = mainTable(hands);
  const bool any = std::any_of(hands.begin(), hands.end(), [](const HandSummary& hand) {
    return std::any_of(hand.baselines.begin(), hand.baselines.end(), [](const auto& method) {
      return method.grasps > 0;
    });
  });
  if (any) text += "\n" + baselineTable(hands);
  return text;
}

}  // namespace handgraft::bench
