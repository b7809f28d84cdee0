#include "client/cli/study/sweep_result.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/base/error.h"

namespace handgraft::client {

void requireConsistent(const SweepResult& result) {
  std::size_t rows = result.grasps.size();
  for (const StudyAxis& axis : result.axes)
    rows *= axis.axis.values().size();
  bool fits = result.reply.rows().size() == rows;
  for (std::size_t i = 0; fits && i < rows; ++i) {
    const v1::SweepRow& row = result.reply.rows()[i];
    fits = row.grasp() == i % result.grasps.size() &&
           row.values().size() == result.axes.size() &&
           (!row.error().empty() ||
            row.joint_positions().size() == result.reply.joint_names().size());
  }
  if (!fits) {
    throw TransportError(
        fmt::format("the server's answer to a sweep of {} rows does not fit it", rows));
  }
}

std::vector<SweepPoint> pointsOf(const SweepResult& result) {
  std::vector<SweepPoint> points;
  const std::vector<v1::SweepRow>& rows = result.reply.rows();
  for (std::size_t first = 0; first < rows.size(); first += result.grasps.size()) {
    SweepPoint point;
    point.values = rows[first].values();
    for (std::size_t i = first; i < first + result.grasps.size(); ++i) {
      if (!rows[i].error().empty()) continue;
      ++point.solved;
      point.mean_mm += rows[i].mean_mm();
      point.worst_mm = std::max(point.worst_mm, rows[i].mean_mm());
      point.patches += static_cast<int>(rows[i].patch_count());
      point.reached += static_cast<int>(rows[i].reached_count());
    }
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    point.mean_mm = point.solved > 0 ? point.mean_mm / point.solved : kNone;
    if (point.solved == 0) point.worst_mm = kNone;
    points.push_back(std::move(point));
  }
  return points;
}

std::size_t bestOf(const std::vector<SweepPoint>& points) {
  std::size_t best = 0;
  for (std::size_t i = 1; i < points.size(); ++i) {
    const bool is_better =
        points[i].solved > points[best].solved ||
        (points[i].solved == points[best].solved && points[i].mean_mm < points[best].mean_mm);
    if (is_better) best = i;
  }
  return best;
}

FirstLoss firstLossOf(const std::vector<SweepPoint>& points, std::size_t best) {
  std::vector<std::size_t> order(points.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return points[a].values.front() < points[b].values.front();
  });
  const auto at = std::find(order.begin(), order.end(), best);
  const auto loses = [&](std::size_t i) {
    return points[i].reached < points[best].reached;
  };
  FirstLoss loss;
  const auto above = std::find_if(at, order.end(), loses);
  if (above != order.end()) loss.above = *above;
  const auto below = std::find_if(std::make_reverse_iterator(at), order.rend(), loses);
  if (below != order.rend()) loss.below = *below;
  return loss;
}

std::string axisLabel(const SweepResult& result, std::size_t axis) {
  const std::string& unit = result.units[axis];
  return result.axes[axis].name + (unit.empty() ? "" : " (" + unit + ")");
}

}  // namespace handgraft::client
