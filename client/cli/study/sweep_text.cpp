#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "client/cli/study/sweep_result.h"
#include "client/present/text_output.h"

namespace handgraft::client {

namespace {

/// Points shown of a sweep over several axes, best first.
constexpr std::size_t kShownPoints = 12;

std::string valueText(const SweepResult& result, std::size_t axis, double value) {
  return fmt::format("{:.5g}", result.axes[axis].shown(value));
}

/// `thumb_mcp.upper = 0.6 rad, hand.size = 1.1`
std::string placeText(const SweepResult& result, const SweepPoint& point) {
  std::string text;
  for (std::size_t a = 0; a < result.axes.size(); ++a) {
    text += fmt::format("{}{} = {}{}", a == 0 ? "" : ", ", text::plain(result.axes[a].name),
                        valueText(result, a, point.values[a]),
                        result.units[a].empty() ? "" : " " + result.units[a]);
  }
  return text;
}

std::string tiesText(const SweepResult& result,
                     const std::vector<SweepPoint>& points,
                     const std::vector<std::size_t>& ties) {
  constexpr std::size_t kMostShown = 4;
  if (ties.empty()) return "";
  std::string out = "as good:";
  for (std::size_t i = 0; i < std::min(ties.size(), kMostShown); ++i)
    out += fmt::format("{} {}", i == 0 ? "" : ";", placeText(result, points[ties[i]]));
  if (ties.size() > kMostShown) out += fmt::format("; {} more", ties.size() - kMostShown);
  return out + "\n";
}

/// Which grasps reach fewer patches at one point than at another.
std::string losersAt(const SweepResult& result, std::size_t point, std::size_t best) {
  const std::size_t count = result.grasps.size();
  std::string names;
  for (std::size_t g = 0; g < count; ++g) {
    const v1::SweepRow& there = result.reply.rows()[point * count + g];
    const v1::SweepRow& before = result.reply.rows()[best * count + g];
    const StudyGrasp& grasp = result.grasps[g];
    if (!there.error().empty() || there.reached_count() >= before.reached_count()) continue;
    names += fmt::format("{}{} {} of {}{}", names.empty() ? "" : ", ", text::plain(grasp.label),
                         there.reached_count(), there.patch_count(),
                         grasp.isMotion() ? " frames" : "");
  }
  return names;
}

std::string lossText(const SweepResult& result,
                     const std::vector<SweepPoint>& points,
                     std::size_t best) {
  const FirstLoss loss = firstLossOf(points, best);
  std::string out;
  const auto add = [&](const char* way, const std::optional<std::size_t>& point) {
    if (!point) return;
    out += fmt::format("{} it the first patch is lost at {} ({})\n", way,
                       placeText(result, points[*point]), losersAt(result, *point, best));
  };
  const bool reaches_any =
      std::any_of(points.begin(), points.end(), [](const SweepPoint& point) {
        return point.reached > 0.0;
      });
  if (!reaches_any) return "no patch is reached at any value\n";
  add("below", loss.below);
  add("above", loss.above);
  return out.empty() ? "no patch is lost on either side\n" : out;
}

/// Of a limit that is varied, values that permit more than the best and come to less: each
/// row is searched for by itself.
std::string widerText(const SweepResult& result,
                      const std::vector<SweepPoint>& points,
                      std::size_t best) {
  const v1::HandProperty property = result.axes[0].axis.property();
  if (property != v1::PROPERTY_UPPER && property != v1::PROPERTY_LOWER) return "";
  std::string out;
  for (const SweepPoint& point : points) {
    const double wider = property == v1::PROPERTY_UPPER
                             ? point.values[0] - points[best].values[0]
                             : points[best].values[0] - point.values[0];
    if (!(wider > 0.0) || point.solved == 0 || point.reached >= points[best].reached) continue;
    const std::string unit = result.units[0].empty() ? "" : " " + result.units[0];
    out += fmt::format(
        "{}{} permits all that {}{} does, and its search came to less: what is reached "
        "there is in reach here\n",
        valueText(result, 0, point.values[0]), unit,
        valueText(result, 0, points[best].values[0]), unit);
  }
  return out;
}

/// Of each combination shown in how much of a motion's frames each of its patches is reached,
/// and all that are there. `motion` is followed by its patches.
std::string motionText(const SweepResult& result,
                       std::size_t motion,
                       const std::vector<SweepPoint>& points,
                       const std::vector<std::size_t>& order) {
  const std::size_t count = result.grasps.size();
  std::size_t end = motion + 1;
  while (end < count && !result.grasps[end].patch.empty())
    ++end;
  std::vector<std::vector<std::string>> rows(1);
  for (std::size_t a = 0; a < result.axes.size(); ++a)
    rows[0].push_back(text::plain(axisLabel(result, a)));
  rows[0].push_back("all");
  for (std::size_t g = motion + 1; g < end; ++g)
    rows[0].push_back(text::plain(result.grasps[g].patch));
  for (const std::size_t i : order) {
    const auto row_at = [&](std::size_t g) -> const v1::SweepRow& {
      return result.reply.rows()[i * count + g];
    };
    if (!row_at(motion).error().empty()) continue;
    std::vector<std::string>& line = rows.emplace_back();
    for (std::size_t a = 0; a < result.axes.size(); ++a)
      line.push_back(valueText(result, a, points[i].values[a]));
    for (std::size_t g = motion; g < end; ++g) {
      const double percent = percentReached(row_at(g));
      line.push_back(std::isfinite(percent) ? fmt::format("{:.0f} %", percent) : "-");
    }
  }
  if (rows.size() == 1) return "";
  return fmt::format("\n{}: in how many of its frames each patch is reached\n{}",
                     text::plain(result.grasps[motion].label), text::table(rows, "r"));
}

}  // namespace

namespace text {

std::string sweep(const SweepResult& result) {
  const std::vector<SweepPoint> points = pointsOf(result);
  const std::size_t best = bestOf(points);
  std::string out =
      fmt::format("{}: {}, {} rows in {:.2f} s\n\n", plain(result.hand), studiedText(result),
                  result.reply.rows().size(), 1e-3 * result.reply.total_ms());

  // === A line a combination; of many the best
  std::vector<std::size_t> order(points.size());
  for (std::size_t i = 0; i < order.size(); ++i)
    order[i] = i;
  if (result.axes.size() > 1) {
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return isBetter(points[a], points[b]);
    });
    order.resize(std::min(order.size(), kShownPoints));
  }
  std::vector<std::vector<std::string>> rows(1);
  for (std::size_t a = 0; a < result.axes.size(); ++a)
    rows[0].push_back(plain(axisLabel(result, a)));
  rows[0].insert(rows[0].end(), {"mean mm", "worst grasp mm", "inside mm", "in itself mm",
                                 "patches reached", "grasps"});
  for (const std::size_t i : order) {
    const SweepPoint& point = points[i];
    std::vector<std::string>& row = rows.emplace_back();
    for (std::size_t a = 0; a < result.axes.size(); ++a)
      row.push_back(valueText(result, a, point.values[a]));
    row.insert(row.end(), {millimetresText(point.mean_mm), millimetresText(point.worst_mm),
                           millimetresText(point.deepest_mm), millimetresText(point.self_mm),
                           fmt::format("{} of {}", countText(point.reached), point.patches),
                           fmt::format("{} of {}", point.solved, studiedCount(result))});
  }
  out += table(rows, "r");
  if (order.size() < points.size())
    out += fmt::format("... the best {} of {}\n", order.size(), points.size());

  for (std::size_t g = 0; g < result.grasps.size(); ++g)
    if (result.grasps[g].isMotion() && result.grasps[g].patch.empty())
      out += motionText(result, g, points, order);

  // === What it says
  if (points[best].solved == 0) {
    out += "\nno grasp has an answer\n";
  } else {
    out += fmt::format("\nbest: {}, mean {} mm\n", placeText(result, points[best]),
                       millimetresText(points[best].mean_mm));
    out += tiesText(result, points, asGoodAs(best, points));
    if (result.axes.size() == 1 && points.size() > 1)
      out += lossText(result, points, best) + widerText(result, points, best);
  }
  std::string last;
  for (const v1::SweepRow& row : result.reply.rows()) {
    if (row.error().empty() || row.error() == last) continue;
    last = row.error();
    out += fmt::format("no answer for {}: {}\n", plain(result.grasps[row.grasp()].label),
                       plain(row.error()));
  }
  out += notes(result.notes);
  return out;
}

}  // namespace text

}  // namespace handgraft::client
