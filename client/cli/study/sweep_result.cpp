#include "client/cli/study/sweep_result.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>

#include "core/base/error.h"

namespace handgraft::client {

void requireConsistent(const SweepResult& result) {
  std::size_t rows = result.grasps.size();
  for (const StudyAxis& axis : result.axes)
    rows *= axis.axis.values().size();
  bool fits = result.reply.rows().size() == rows;
  for (std::size_t i = 0; fits && i < rows; ++i) {
    const v1::SweepRow& row = result.reply.rows()[i];
    fits =
        row.grasp() == i % result.grasps.size() && row.values().size() == result.axes.size() &&
        (!row.error().empty() ||
         row.joint_positions().size() ==
             (result.grasps[row.grasp()].isMotion() ? 0 : result.reply.joint_names().size()));
    fits = fits && row.reached_count() <= row.patch_count();
  }
  if (!fits) {
    throw TransportError(
        fmt::format("the server's answer to a sweep of {} rows does not fit it", rows));
  }
}

std::vector<StudyGrasp> withPatches(const StudyGrasp& motion,
                                    const std::vector<std::string>& patches) {
  std::vector<StudyGrasp> all = {motion};
  for (const std::string& patch : patches) {
    all.push_back(motion);
    all.back().label += "/" + patch;
    all.back().patch = patch;
  }
  return all;
}

int studiedCount(const SweepResult& result) {
  return static_cast<int>(
      std::count_if(result.grasps.begin(), result.grasps.end(), [](const StudyGrasp& grasp) {
        return grasp.patch.empty();
      }));
}

double patchesOf(const StudyGrasp& grasp, const v1::SweepRow& row) {
  if (!grasp.isMotion()) return row.patch_count();
  return grasp.patch.empty() || row.patch_count() == 0 ? 0.0 : 1.0;
}

double reachedBy(const StudyGrasp& grasp, const v1::SweepRow& row) {
  if (!grasp.isMotion()) return row.reached_count();
  return patchesOf(grasp, row) == 0.0
             ? 0.0
             : static_cast<double>(row.reached_count()) / row.patch_count();
}

std::string countText(double count) {
  const double whole = std::round(count);
  return std::abs(count - whole) < 1e-6 ? fmt::format("{:.0f}", whole)
                                        : fmt::format("{:.1f}", count);
}

std::string millimetresText(double value_mm) {
  return std::isfinite(value_mm) ? fmt::format("{:.2f}", value_mm) : "-";
}

std::string studiedText(const SweepResult& result) {
  int motions = 0;
  for (const StudyGrasp& grasp : result.grasps)
    motions += grasp.isMotion() && grasp.patch.empty() ? 1 : 0;
  const auto counted = [](int count, const char* what) {
    return count == 0 ? std::string()
                      : fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
  };
  const std::string grasps = counted(studiedCount(result) - motions, "grasp");
  const std::string moving = counted(motions, "motion");
  return grasps + (grasps.empty() || moving.empty() ? "" : " and ") + moving;
}

double percentReached(const v1::SweepRow& row) {
  return row.patch_count() > 0 ? 100.0 * row.reached_count() / row.patch_count()
                               : std::numeric_limits<double>::quiet_NaN();
}

std::vector<SweepPoint> pointsOf(const SweepResult& result) {
  std::vector<SweepPoint> points;
  const std::vector<v1::SweepRow>& rows = result.reply.rows();
  // What one hand drops, another one may have: at each point all of them are asked for.
  std::vector<double> asked(result.grasps.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    double& most = asked[i % result.grasps.size()];
    if (rows[i].error().empty())
      most = std::max(most, patchesOf(result.grasps[rows[i].grasp()], rows[i]));
  }
  for (std::size_t first = 0; first < rows.size(); first += result.grasps.size()) {
    SweepPoint point;
    point.values = rows[first].values();
    for (std::size_t i = first; i < first + result.grasps.size(); ++i) {
      if (!rows[i].error().empty()) continue;
      const StudyGrasp& grasp = result.grasps[rows[i].grasp()];
      point.patches += static_cast<int>(asked[i - first]);
      point.reached += reachedBy(grasp, rows[i]);
      if (!grasp.patch.empty()) continue;
      ++point.solved;
      point.mean_mm += rows[i].mean_mm();
      point.worst_mm = std::max(point.worst_mm, rows[i].mean_mm());
      point.deepest_mm = std::max(point.deepest_mm, 1e3 * rows[i].max_depth_m());
      point.self_mm = std::max(point.self_mm, 1e3 * rows[i].self_depth_m());
    }
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    point.mean_mm = point.solved > 0 ? point.mean_mm / point.solved : kNone;
    if (point.solved == 0) point.worst_mm = point.deepest_mm = point.self_mm = kNone;
    points.push_back(std::move(point));
  }
  return points;
}

bool isBetter(const SweepPoint& a, const SweepPoint& b) {
  if (a.solved != b.solved) return a.solved > b.solved;
  const auto tenths = [](const SweepPoint& point) {
    return std::lround(10.0 * point.reached);  // shares of a motion's frames: as countText
  };
  if (tenths(a) != tenths(b)) return tenths(a) > tenths(b);
  return a.mean_mm < b.mean_mm;
}

std::size_t bestOf(const std::vector<SweepPoint>& points) {
  std::size_t best = 0;
  for (std::size_t i = 1; i < points.size(); ++i)
    if (isBetter(points[i], points[best])) best = i;
  return best;
}

std::vector<std::size_t> asGoodAs(std::size_t best, const std::vector<SweepPoint>& points) {
  const auto shown = [&](std::size_t i) {
    return std::tuple(points[i].solved, millimetresText(points[i].mean_mm),
                      countText(points[i].reached));
  };
  std::vector<std::size_t> others;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (i != best && shown(i) == shown(best)) others.push_back(i);
  return others;
}

FirstLoss firstLossOf(const std::vector<SweepPoint>& points, std::size_t best) {
  std::vector<std::size_t> order(points.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return points[a].values.front() < points[b].values.front();
  });
  const auto at = std::find(order.begin(), order.end(), best);
  constexpr double kLost = 0.5;  // of a patch
  const auto loses = [&](std::size_t i) {
    // What has no answer has lost nothing that anybody knows of.
    return points[i].patches - points[i].reached >=
           points[best].patches - points[best].reached + kLost;
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
