#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include <fmt/format.h>

#include "client/cli/study/sweep_result.h"
#include "client/present/render/plot.h"
#include "core/base/error.h"

namespace handgraft::client {

namespace {

/// More lines than this are one crowd: grey, and without names.
constexpr std::size_t kMostNamed = 20;
constexpr render::Color kCrowd{176, 182, 191};
constexpr render::Color kMean{24, 28, 34};

std::string titleOf(const SweepResult& result) {
  std::string axes;
  for (const StudyAxis& axis : result.axes)
    axes += (axes.empty() ? "" : " and ") + axis.name;
  return fmt::format("{}: {} over {} grasp{}", result.hand, axes, result.grasps.size(),
                     result.grasps.size() == 1 ? "" : "s");
}

std::string bestText(const SweepResult& result, const std::vector<SweepPoint>& points) {
  const SweepPoint& best = points[bestOf(points)];
  if (best.solved == 0) return "no grasp has an answer";
  std::string values;
  for (std::size_t a = 0; a < result.axes.size(); ++a)
    values +=
        fmt::format("{}{:.4g}{}", a == 0 ? "" : ", ", result.axes[a].shown(best.values[a]),
                    result.units[a].empty() ? "" : " " + result.units[a]);
  return fmt::format("best at {}: mean distance {:.2f} mm, {} of {} patches reached", values,
                     best.mean_mm, best.reached, best.patches);
}

render::Image curves(const SweepResult& result) {
  const std::vector<SweepPoint> points = pointsOf(result);
  const std::size_t count = result.grasps.size();
  std::vector<std::size_t> order(points.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return points[a].values.front() < points[b].values.front();
  });

  render::PlotPanel distance;
  distance.label = "mean distance (mm)";
  distance.height = 1.6;
  render::PlotPanel share;
  share.label = "patches reached (%)";
  share.range = {0.0, 100.0};
  const double nothing = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t g = 0; g < count; ++g) {
    render::PlotLine line;
    line.width = 1.6;
    const bool is_named = count <= kMostNamed;
    line.color = is_named ? render::blend(render::plotColor(g), {255, 255, 255}, 0.25) : kCrowd;
    if (is_named) line.name = result.grasps[g].label;
    render::PlotLine reached = line;
    for (const std::size_t i : order) {
      const v1::SweepRow& row = result.reply.rows()[i * count + g];
      const double x = result.axes[0].shown(points[i].values[0]);
      const bool has_answer = row.error().empty();
      line.x.push_back(x);
      line.y.push_back(has_answer ? row.mean_mm() : nothing);
      reached.x.push_back(x);
      reached.y.push_back(has_answer && row.patch_count() > 0
                              ? 100.0 * row.reached_count() / row.patch_count()
                              : nothing);
    }
    distance.lines.push_back(std::move(line));
    share.lines.push_back(std::move(reached));
  }
  render::PlotLine mean;
  mean.color = kMean;
  mean.width = 4.0;
  mean.dots = true;
  mean.name = "mean";
  render::PlotLine mean_share = mean;
  for (const std::size_t i : order) {
    const double x = result.axes[0].shown(points[i].values[0]);
    mean.x.push_back(x);
    mean.y.push_back(points[i].mean_mm);
    mean_share.x.push_back(x);
    mean_share.y.push_back(points[i].patches > 0 ? 100.0 * points[i].reached / points[i].patches
                                                 : nothing);
  }
  if (count > 1) {
    distance.lines.push_back(mean);
    share.lines.push_back(mean_share);
  }
  // Distances begin at nothing: half as high is half as far.
  double highest = 0.0;
  for (const render::PlotLine& line : distance.lines)
    for (const double y : line.y)
      if (std::isfinite(y)) highest = std::max(highest, y);
  distance.range = {0.0, highest > 0.0 ? highest : 1.0};
  return render::drawPlot(
      {titleOf(result), bestText(result, points), axisLabel(result, 0), {distance, share}});
}

render::Image heatMap(const SweepResult& result) {
  const std::vector<SweepPoint> points = pointsOf(result);
  render::HeatMap map;
  map.title = titleOf(result);
  map.subtitle = bestText(result, points);
  map.x_label = axisLabel(result, 1);
  map.y_label = axisLabel(result, 0);
  map.value_label = "mean distance (mm)";
  const std::size_t columns = result.axes[1].axis.values().size();
  for (const double value : result.axes[1].axis.values())
    map.x.push_back(result.axes[1].shown(value));
  for (std::size_t j = 0; j < result.axes[0].axis.values().size(); ++j) {
    map.y.push_back(result.axes[0].shown(result.axes[0].axis.values()[j]));
    std::vector<double>& row = map.values.emplace_back();
    for (std::size_t i = 0; i < columns; ++i)
      row.push_back(points[j * columns + i].mean_mm);
  }
  return render::drawHeatMap(map);
}

}  // namespace

render::Image pictureOf(const SweepResult& result) {
  if (result.axes.size() == 1) return curves(result);
  if (result.axes.size() == 2) return heatMap(result);
  rejectInput("a picture shows one property or two, not {}", result.axes.size());
}

}  // namespace handgraft::client
