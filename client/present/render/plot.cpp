#include "client/present/render/plot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "client/present/render/plot_parts.h"
#include "client/present/render/text.h"
#include "core/base/error.h"

namespace handgraft::client::render {

namespace {

constexpr int kLeastSide = 300;
constexpr int kPad = 24;
constexpr int kTick = 8;
constexpr int kSwatch = 34;
constexpr int kMostXTicks = 10;
constexpr double kDotRadius = 4.5;

/// Told apart in print and by most colour-blind readers; the order of Tableau's ten.
constexpr std::array<Color, 10> kColors = {{{31, 119, 180},
                                            {255, 127, 14},
                                            {44, 160, 44},
                                            {214, 39, 40},
                                            {148, 103, 189},
                                            {140, 86, 75},
                                            {227, 119, 194},
                                            {127, 127, 127},
                                            {188, 189, 34},
                                            {23, 190, 207}}};

void requireSound(const Plot& plot, PictureSize size) {
  if (size.width < kLeastSide || size.height < kLeastSide)
    rejectInput("plot: {} x {} pixels; at least {} x {} are needed", size.width, size.height,
                kLeastSide, kLeastSide);
  if (plot.panels.empty()) rejectInput("plot {}: it has no panels", quoted(plot.title));
  for (const PlotPanel& panel : plot.panels) {
    for (const PlotLine& line : panel.lines) {
      if (line.x.size() != line.y.size())
        rejectInput("plot {}: line {} has {} values of x and {} of y", quoted(plot.title),
                    quoted(line.name), line.x.size(), line.y.size());
    }
  }
}

/// What values cover; [0, 1] if there are none.
class Extent {
 public:
  void add(const std::vector<double>& values) {
    for (const double value : values) {
      if (!std::isfinite(value)) continue;
      low_ = std::min(low_, value);
      high_ = std::max(high_, value);
    }
  }

  [[nodiscard]] std::pair<double, double> range() const {
    if (!(low_ <= high_)) return {0.0, 1.0};
    if (low_ < high_) return {low_, high_};
    const double room = low_ == 0.0 ? 1.0 : 0.1 * std::abs(low_);
    return {low_ - room, high_ + room};
  }

 private:
  double low_ = std::numeric_limits<double>::infinity();
  double high_ = -std::numeric_limits<double>::infinity();
};

std::pair<double, double> rangeOfX(const Plot& plot) {
  Extent extent;
  for (const PlotPanel& panel : plot.panels)
    for (const PlotLine& line : panel.lines)
      extent.add(line.x);
  return extent.range();
}

/// Named lines, each name once, the last of a name deciding how it looks.
std::vector<PlotLine> legendOf(const Plot& plot) {
  std::vector<PlotLine> legend;
  for (const PlotPanel& panel : plot.panels) {
    if (panel.names_at_ends) continue;
    for (const PlotLine& line : panel.lines) {
      if (line.name.empty()) continue;
      const auto same = std::find_if(legend.begin(), legend.end(), [&](const PlotLine& other) {
        return other.name == line.name;
      });
      if (same == legend.end())
        legend.push_back({{}, {}, line.color, line.width, line.dots, line.name});
    }
  }
  return legend;
}

void drawLine(Image& image,
              const PlotArea& area,
              const PlotLine& line,
              const PlotScale& x,
              const PlotScale& y) {
  std::vector<PlotPoint> run;
  const auto flush = [&] {
    if (run.size() == 1 && !line.dots)
      drawDot(image, area, run.front(), line.width, line.color);
    drawPolyline(image, area, run, line.width, line.color);
    run.clear();
  };
  for (std::size_t i = 0; i < line.x.size(); ++i) {
    if (std::isfinite(line.x[i]) && std::isfinite(line.y[i])) {
      run.push_back({x(line.x[i]), y(line.y[i])});
      if (line.dots) drawDot(image, area, run.back(), kDotRadius, line.color);
    } else {
      flush();
    }
  }
  flush();
}

/// The last point of a line that has a name.
std::optional<PlotPoint> namedEnd(const PlotLine& line,
                                  const PlotScale& x,
                                  const PlotScale& y) {
  if (line.name.empty()) return std::nullopt;
  for (std::size_t i = line.x.size(); i-- > 0;)
    if (std::isfinite(line.x[i]) && std::isfinite(line.y[i]))
      return PlotPoint{x(line.x[i]), y(line.y[i])};
  return std::nullopt;
}

/// Names in the order in which their lines end, each as near to its end as the others permit,
/// and a thin line from the end to the name.
void drawNamesAtEnds(Image& image,
                     const PlotArea& area,
                     const std::vector<PlotLine>& lines,
                     const PlotScale& x,
                     const PlotScale& y) {
  struct Name {
    const PlotLine* line = nullptr;
    PlotPoint end;
    double row = 0.0;  // its middle
  };

  std::vector<Name> names;
  for (const PlotLine& line : lines)
    if (const auto end = namedEnd(line, x, y)) names.push_back({&line, *end, end->y});
  std::stable_sort(names.begin(), names.end(), [](const Name& a, const Name& b) {
    return a.end.y < b.end.y;
  });
  // Down to below the one above, then up again to what still fits above the area's bottom.
  const double height = plotNameHeight();
  double least = area.top + 0.5 * height;
  for (Name& name : names) {
    name.row = std::max(name.row, least);
    least = name.row + height;
  }
  double most = area.bottom() - 0.5 * height;
  for (std::size_t i = names.size(); i-- > 0;) {
    names[i].row = std::min(names[i].row, most);
    most = names[i].row - height;
  }

  const int left = area.right() + kPad;
  const PlotArea whole{0, 0, image.width(), image.height()};
  for (const Name& name : names) {
    drawPolyline(image, whole,
                 {name.end, {area.right() + 4.0, name.end.y}, {left + 1.0 * kSwatch, name.row}},
                 1.0, name.line->color);
    drawText(image, left + kSwatch + 10,
             static_cast<int>(std::lround(name.row - 0.4 * textHeight(kPlotTextScale))),
             kPlotTextScale, kPlotInk, name.line->name);
  }
}

void drawPanel(Image& image,
               const PlotArea& area,
               const PlotPanel& panel,
               const std::pair<double, double>& x_range,
               bool is_last) {
  Extent extent;
  for (const PlotLine& line : panel.lines)
    extent.add(line.y);
  const std::pair<double, double> wanted = panel.range.value_or(extent.range());
  const std::vector<double> y_ticks =
      roundTicks(wanted.first, wanted.second, std::max(2, area.height / 60));
  const PlotScale x(x_range.first, x_range.second, area.left, area.right());
  const PlotScale y(std::min(wanted.first, y_ticks.front()),
                    std::max(wanted.second, y_ticks.back()), area.bottom(), area.top);

  // === Grid and labels
  const std::vector<std::string> y_labels = tickLabels(y_ticks);
  for (std::size_t i = 0; i < y_ticks.size(); ++i) {
    const int row = static_cast<int>(std::lround(y(y_ticks[i])));
    image.fill(area.left, row, area.width, 1, kPlotGrid);
    drawFlushRight(image, area.left - kTick - 6, row - textHeight(kPlotTextScale) / 2 + 2,
                   kPlotFaint, y_labels[i]);
  }
  const std::vector<double> x_ticks = roundTicks(x_range.first, x_range.second, kMostXTicks);
  const std::vector<std::string> x_labels = tickLabels(x_ticks);
  for (std::size_t i = 0; i < x_ticks.size(); ++i) {
    const int column = static_cast<int>(std::lround(x(x_ticks[i])));
    if (column < area.left || column > area.right()) continue;
    image.fill(column, area.top, 1, area.height, kPlotGrid);
    image.fill(column, area.bottom(), 2, kTick, kPlotFaint);
    if (is_last) drawCentred(image, column, area.bottom() + kTick + 6, kPlotFaint, x_labels[i]);
  }
  image.fill(area.left - 1, area.top, 2, area.height, kPlotFaint);
  image.fill(area.left - 1, area.bottom(), area.width + 1, 2, kPlotFaint);
  drawText(image, area.left, area.top - textHeight(kPlotTextScale) - 8, kPlotTextScale,
           kPlotInk, panel.label);

  // Lines may run along the frame: a little room about the area.
  const PlotArea room{area.left - 6, area.top - 6, area.width + 12, area.height + 12};
  for (const PlotLine& line : panel.lines)
    drawLine(image, room, line, x, y);
  if (panel.names_at_ends) drawNamesAtEnds(image, area, panel.lines, x, y);
}

/// Names that would end below `bottom` are left out.
void drawLegend(
    Image& image, int left, int top, int bottom, const std::vector<PlotLine>& legend) {
  const int line_height = textHeight(kPlotTextScale) + 10;
  int row = top;
  for (const PlotLine& line : legend) {
    if (row + line_height > bottom) break;
    const PlotArea area{left, row - 4, kSwatch + 8, line_height};
    const double middle = row + 0.4 * textHeight(kPlotTextScale);
    drawPolyline(image, area, {{left + 4.0, middle}, {left + 1.0 * kSwatch, middle}},
                 std::max(line.width, 2.0), line.color);
    if (line.dots)
      drawDot(image, area, {left + 0.55 * kSwatch, middle}, kDotRadius, line.color);
    drawText(image, left + kSwatch + 10, row, kPlotTextScale, kPlotInk, line.name);
    row += line_height;
  }
}

}  // namespace

Image drawPlot(const Plot& plot, PictureSize size) {
  requireSound(plot, size);
  Image image(size.width, size.height);
  const int head = drawHeading(image, plot.title, plot.subtitle);

  // === Where everything goes
  const std::vector<PlotLine> legend = legendOf(plot);
  int legend_width = 0;
  const auto make_room = [&](const PlotLine& line) {
    if (line.name.empty()) return;
    legend_width =
        std::max(legend_width, kSwatch + 10 + textWidth(line.name, kPlotTextScale) + kPad);
  };
  for (const PlotPanel& panel : plot.panels)
    std::for_each(panel.lines.begin(), panel.lines.end(), make_room);
  legend_width = std::min(legend_width, size.width / 3);
  const int text = textHeight(kPlotTextScale);
  PlotArea all;
  all.left = 110;
  all.top = head + text + 16;
  all.width = size.width - all.left - 2 * kPad - legend_width;
  all.height = size.height - all.top - (kTick + 6 + text) - (text + 14) - kPad;

  // === Panels
  const std::pair<double, double> x_range = rangeOfX(plot);
  const int gap = 2 * text + 24;
  double shares = 0.0;
  for (const PlotPanel& panel : plot.panels)
    shares += panel.height;
  const double free = all.height - gap * static_cast<double>(plot.panels.size() - 1);
  PlotArea area = all;
  int legend_bottom = image.height();
  for (std::size_t i = 0; i < plot.panels.size(); ++i) {
    area.height = static_cast<int>(free * plot.panels[i].height / shares);
    drawPanel(image, area, plot.panels[i], x_range, i + 1 == plot.panels.size());
    if (plot.panels[i].names_at_ends) legend_bottom = std::min(legend_bottom, area.top);
    if (i + 1 < plot.panels.size()) area.top += area.height + gap;
  }
  drawCentred(image, all.left + all.width / 2, area.bottom() + kTick + 6 + text + 14, kPlotInk,
              plot.x_label);
  drawLegend(image, all.right() + kPad, all.top, legend_bottom, legend);
  return image;
}

int plotNameHeight() {
  return textHeight(kPlotTextScale) + 6;
}

Color plotColor(std::size_t index) {
  return kColors[index % kColors.size()];
}

std::vector<double> roundTicks(double low, double high, int most) {
  if (!(low < high)) return {low};
  const double rough = (high - low) / most;
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  double step = 10.0 * power;
  for (const double factor : {1.0, 2.0, 2.5, 5.0}) {
    if (factor * power >= rough * (1.0 - 1e-9)) {
      step = factor * power;
      break;
    }
  }
  // Rounding must not add a step beyond a bound that is itself a tick.
  const double first = std::floor(low / step + 1e-6);
  const double last = std::ceil(high / step - 1e-6);
  std::vector<double> ticks;
  for (int i = 0; i <= last - first; ++i)
    ticks.push_back(first + i == 0.0 ? 0.0 : (first + i) * step);
  return ticks;
}

std::vector<std::string> tickLabels(const std::vector<double>& ticks) {
  double step = 0.0;
  double largest = 0.0;
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    if (i > 0) step = std::max(step, std::abs(ticks[i] - ticks[i - 1]));
    largest = std::max(largest, std::abs(ticks[i]));
  }
  const bool is_plain = largest < 1e5 && (step == 0.0 || step >= 1e-4);
  int decimals = 0;
  for (double rest = step; decimals < 6; ++decimals, rest *= 10.0)
    if (std::abs(rest - std::round(rest)) < 1e-6) break;
  std::vector<std::string> labels;
  labels.reserve(ticks.size());
  for (const double tick : ticks)
    labels.push_back(is_plain ? fmt::format("{:.{}f}", tick, decimals)
                              : fmt::format("{:.3g}", tick));
  return labels;
}

}  // namespace handgraft::client::render
