#include "client/present/minima_text.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <fmt/format.h>

#include "client/link/wire_pose.h"
#include "client/present/joint_unit.h"
#include "client/present/text_output.h"

namespace handgraft::client {

namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;
constexpr double kMillimetres = 1e3;

}  // namespace

PoseGap gapBetween(const v1::MinimumInfo& a,
                   const v1::MinimumInfo& b,
                   const v1::HandDescription& hand) {
  const Pose X_AB = poseOf(a.X_WH()).inverse() * poseOf(b.X_WH());
  PoseGap gap;
  gap.moved_mm = kMillimetres * X_AB.translation().norm();
  gap.turned_deg = kDegrees * vectorFromRotation(X_AB.linear()).norm();
  const std::size_t joints =
      std::min({a.joint_positions().size(), b.joint_positions().size(), hand.joints().size()});
  for (std::size_t j = 0; j < joints; ++j) {
    gap.joint =
        std::max(gap.joint, unitOf(hand.joints()[j].kind()).scale *
                                std::abs(a.joint_positions()[j] - b.joint_positions()[j]));
  }
  return gap;
}

std::string text::minima(const v1::PoseSolution& solution, const v1::HandDescription& hand) {
  if (solution.minima().empty()) return "";
  const bool slides =
      std::any_of(hand.joints().begin(), hand.joints().end(), [](const v1::JointInfo& joint) {
        return joint.kind() == v1::JOINT_PRISMATIC;
      });
  std::vector<std::vector<std::string>> rows = {{"rank", "solver", "objective", "hits", "start",
                                                 "moved mm", "turned deg",
                                                 slides ? "joint deg or mm" : "joint deg", ""}};
  std::size_t rank = 0;
  for (const v1::MinimumInfo& minimum : solution.minima()) {
    const PoseGap gap = gapBetween(solution.minima().front(), minimum, hand);
    const bool chosen = rank == solution.chosen_minimum();
    ++rank;
    rows.push_back({std::to_string(rank), plain(minimum.solver()),
                    fmt::format("{:.6g}", minimum.terms().objective()),
                    std::to_string(minimum.hits()), std::to_string(minimum.start()),
                    fmt::format("{:.1f}", gap.moved_mm), fmt::format("{:.1f}", gap.turned_deg),
                    fmt::format("{:.1f}", gap.joint), chosen ? "taken" : ""});
  }
  return table(rows, "rlrrrrrrl");
}

}  // namespace handgraft::client
