#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include <fmt/format.h>

#include "client/cli/study/sweep_result.h"
#include "client/present/render/plot.h"
#include "core/base/error.h"

namespace handgraft::client {

namespace {

/// More lines than this are one crowd: grey, and without names.
constexpr std::size_t kMostNamed = 20;
/// That have a panel of their own.
constexpr std::size_t kMostMotions = 3;
constexpr render::Color kCrowd{176, 182, 191};
constexpr render::Color kMean{24, 28, 34};

std::string titleOf(const SweepResult& result) {
  std::string axes;
  for (const StudyAxis& axis : result.axes)
    axes += (axes.empty() ? "" : " and ") + axis.name;
  return fmt::format("{}: {} over {}", result.hand, axes, studiedText(result));
}

std::string bestText(const SweepResult& result, const std::vector<SweepPoint>& points) {
  const std::size_t at = bestOf(points);
  const SweepPoint& best = points[at];
  if (best.solved == 0) return "no grasp has an answer";
  std::string values;
  for (std::size_t a = 0; a < result.axes.size(); ++a)
    values +=
        fmt::format("{}{:.4g}{}", a == 0 ? "" : ", ", result.axes[a].shown(best.values[a]),
                    result.units[a].empty() ? "" : " " + result.units[a]);
  const std::size_t ties = asGoodAs(at, points).size();
  return fmt::format("best at {}{}: mean distance {} mm, {} of {} patches reached", values,
                     ties == 0 ? "" : fmt::format(" (and {} more)", ties),
                     millimetresText(best.mean_mm), countText(best.reached), best.patches);
}

/// A line over the values, of one entry's rows.
template <class Value>
render::PlotLine lineOf(const SweepResult& result,
                        std::size_t grasp,
                        const std::vector<std::size_t>& order,
                        const Value& value) {
  render::PlotLine line;
  for (const std::size_t i : order) {
    const v1::SweepRow& row = result.reply.rows()[i * result.grasps.size() + grasp];
    line.x.push_back(result.axes[0].shown(row.values()[0]));
    line.y.push_back(row.error().empty() ? value(row)
                                         : std::numeric_limits<double>::quiet_NaN());
  }
  return line;
}

/// In how many of a motion's frames each of its patches is reached. Colours are others than
/// those of the `used` lines before.
render::PlotPanel motionPanel(const SweepResult& result,
                              std::size_t motion,
                              const std::vector<std::size_t>& order,
                              std::size_t used) {
  render::PlotPanel panel;
  panel.label = result.grasps[motion].label + ": frames reached (%)";
  panel.range = {0.0, 100.0};
  for (std::size_t g = motion + 1; g < result.grasps.size(); ++g) {
    if (result.grasps[g].patch.empty()) break;
    render::PlotLine line = lineOf(result, g, order, percentReached);
    line.color = render::plotColor(used + g - motion - 1);
    line.name = result.grasps[g].patch;
    line.dots = true;
    panel.lines.push_back(std::move(line));
  }
  return panel;
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
  const auto studied = static_cast<std::size_t>(studiedCount(result));
  const bool is_named = studied <= kMostNamed;
  std::size_t drawn = 0;
  for (std::size_t g = 0; g < count; ++g) {
    if (!result.grasps[g].patch.empty()) continue;
    const auto add = [&](render::PlotPanel& panel, const auto& value) {
      render::PlotLine line = lineOf(result, g, order, value);
      line.width = 1.6;
      line.color =
          is_named ? render::blend(render::plotColor(drawn), {255, 255, 255}, 0.25) : kCrowd;
      if (is_named) line.name = result.grasps[g].label;
      panel.lines.push_back(std::move(line));
    };
    add(distance, [](const v1::SweepRow& row) {
      return row.mean_mm();
    });
    add(share, percentReached);
    ++drawn;
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
  if (studied > 1) {
    distance.lines.push_back(mean);
    share.lines.push_back(mean_share);
  }
  std::vector<render::PlotPanel> panels = {distance, share};
  // Distances begin at nothing: half as high is half as far.
  double highest = 0.0;
  for (const render::PlotLine& line : distance.lines)
    for (const double y : line.y)
      if (std::isfinite(y)) highest = std::max(highest, y);
  panels[0].range = {0.0, highest > 0.0 ? highest : 1.0};
  std::size_t motions = 0;
  for (std::size_t g = 0; g < count && motions < kMostMotions; ++g) {
    if (!result.grasps[g].isMotion() || !result.grasps[g].patch.empty()) continue;
    panels.push_back(motionPanel(result, g, order, studied));
    ++motions;
  }
  return render::drawPlot(
      {titleOf(result), bestText(result, points), axisLabel(result, 0), std::move(panels)});
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
  const std::size_t best = bestOf(points);
  if (points[best].solved > 0) map.framed = {best % columns, best / columns};
  return render::drawHeatMap(map);
}

}  // namespace

render::Image pictureOf(const SweepResult& result) {
  if (result.axes.size() == 1) return curves(result);
  if (result.axes.size() == 2) return heatMap(result);
  rejectInput("a picture shows one property or two, not {}", result.axes.size());
}

}  // namespace handgraft::client
