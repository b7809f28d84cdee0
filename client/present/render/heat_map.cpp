#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "client/present/render/plot.h"
#include "client/present/render/plot_parts.h"
#include "client/present/render/text.h"
#include "core/base/error.h"

namespace handgraft::client::render {

namespace {

constexpr int kLeastSide = 300;
constexpr int kPad = 24;
constexpr int kBarWidth = 28;

/// Viridis at even steps: dark is little, also in grey.
constexpr std::array<Color, 6> kViridis = {{{68, 1, 84},
                                            {65, 68, 135},
                                            {42, 120, 142},
                                            {34, 168, 132},
                                            {122, 209, 81},
                                            {253, 231, 37}}};

Color colorOf(double share) {
  const double at = std::clamp(share, 0.0, 1.0) * (kViridis.size() - 1);
  const auto index = std::min(static_cast<std::size_t>(at), kViridis.size() - 2);
  return blend(kViridis[index], kViridis[index + 1], at - static_cast<double>(index));
}

Color inkOn(Color color) {
  const bool is_dark = 0.3 * color.r + 0.6 * color.g + 0.1 * color.b < 140.0;
  return is_dark ? Color{255, 255, 255} : kPlotInk;
}

void requireSound(const HeatMap& map, PictureSize size) {
  if (size.width < kLeastSide || size.height < kLeastSide)
    rejectInput("heat map: {} x {} pixels; at least {} x {} are needed", size.width,
                size.height, kLeastSide, kLeastSide);
  if (map.x.empty() || map.values.size() != map.y.size() || map.y.empty())
    rejectInput("heat map {}: {} rows for {} values of y, {} values of x", quoted(map.title),
                map.values.size(), map.y.size(), map.x.size());
  for (const std::vector<double>& row : map.values)
    if (row.size() != map.x.size())
      rejectInput("heat map {}: a row of {} cells for {} values of x", quoted(map.title),
                  row.size(), map.x.size());
}

void frame(Image& image, const PlotArea& cell, int width, Color color) {
  image.fill(cell.left, cell.top, cell.width, width, color);
  image.fill(cell.left, cell.bottom() - width, cell.width, width, color);
  image.fill(cell.left, cell.top, width, cell.height, color);
  image.fill(cell.right() - width, cell.top, width, cell.height, color);
}

void drawBar(
    Image& image, const PlotArea& area, const std::string& label, double low, double high) {
  for (int row = 0; row < area.height; ++row) {
    const double share = 1.0 - (row + 0.5) / area.height;
    image.fill(area.left, area.top + row, area.width, 1, colorOf(share));
  }
  const std::vector<double> ticks = roundTicks(low, high, 8);
  const std::vector<std::string> labels = tickLabels(ticks);
  const PlotScale y(low, high, area.bottom(), area.top);
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    if (ticks[i] < low || ticks[i] > high) continue;
    const int row = static_cast<int>(std::lround(y(ticks[i])));
    image.fill(area.right(), row, 6, 2, kPlotFaint);
    drawText(image, area.right() + 12, row - textHeight(kPlotTextScale) / 2 + 2, kPlotTextScale,
             kPlotFaint, labels[i]);
  }
  drawText(image, area.left, area.top - textHeight(kPlotTextScale) - 8, kPlotTextScale,
           kPlotInk, label);
}

/// Of the values, as colours show them.
struct Range {
  double low = 0.0;
  double high = 1.0;
};

Range rangeOf(const HeatMap& map) {
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const auto& row : map.values) {
    for (const double value : row) {
      if (!std::isfinite(value)) continue;
      low = std::min(low, value);
      high = std::max(high, value);
    }
  }
  if (low < high) return {low, high};
  // One value, or none.
  const double below = std::isfinite(low) ? low - 0.5 : 0.0;
  return {below, below + 1.0};
}

std::optional<std::pair<std::size_t, std::size_t>> framedIn(const HeatMap& map) {
  if (map.framed) return map.framed;
  std::optional<std::pair<std::size_t, std::size_t>> at;
  for (std::size_t j = 0; j < map.values.size(); ++j) {
    for (std::size_t i = 0; i < map.values[j].size(); ++i) {
      const double value = map.values[j][i];
      if (std::isfinite(value) && (!at || value < map.values[at->second][at->first]))
        at = {i, j};
    }
  }
  return at;
}

/// Where the cells are; rows rise.
struct CellGrid {
  PlotArea area;
  int columns = 1;
  int rows = 1;

  [[nodiscard]] PlotArea cellAt(int i, int j) const {
    PlotArea cell;
    cell.left = area.left + area.width * i / columns;
    cell.width = area.left + area.width * (i + 1) / columns - cell.left;
    cell.top = area.top + area.height * (rows - 1 - j) / rows;
    cell.height = area.top + area.height * (rows - j) / rows - cell.top;
    return cell;
  }
};

void drawCells(Image& image, const CellGrid& grid, const HeatMap& map, const Range& range) {
  const int text = textHeight(kPlotTextScale);
  const bool has_room =
      grid.area.width / grid.columns >= textWidth("00.00", kPlotTextScale) + 8 &&
      grid.area.height / grid.rows >= text + 6;
  for (int j = 0; j < grid.rows; ++j) {
    for (int i = 0; i < grid.columns; ++i) {
      const double value = map.values[static_cast<std::size_t>(j)][static_cast<std::size_t>(i)];
      if (!std::isfinite(value)) continue;
      const PlotArea cell = grid.cellAt(i, j);
      const Color color = colorOf((value - range.low) / (range.high - range.low));
      image.fill(cell.left, cell.top, cell.width, cell.height, color);
      if (has_room)
        drawCentred(image, cell.left + cell.width / 2, cell.top + (cell.height - text) / 2 + 2,
                    inkOn(color), fmt::format("{:.2f}", value));
    }
  }
  if (const auto framed = framedIn(map)) {
    frame(image, grid.cellAt(static_cast<int>(framed->first), static_cast<int>(framed->second)),
          4, {255, 255, 255});
  }
}

// As many labels as there is room for.
void drawColumnLabels(Image& image,
                      const CellGrid& grid,
                      const std::vector<std::string>& labels) {
  int widest = 1;
  for (const std::string& label : labels)
    widest = std::max(widest, textWidth(label, kPlotTextScale) + 16);
  const int step = std::max(1, (widest * grid.columns + grid.area.width - 1) / grid.area.width);
  for (int i = 0; i < grid.columns; i += step) {
    const PlotArea cell = grid.cellAt(i, 0);
    drawCentred(image, cell.left + cell.width / 2, grid.area.bottom() + 12, kPlotFaint,
                labels[static_cast<std::size_t>(i)]);
  }
}

void drawRowLabels(Image& image, const CellGrid& grid, const std::vector<std::string>& labels) {
  const int text = textHeight(kPlotTextScale);
  const int step =
      std::max(1, ((text + 6) * grid.rows + grid.area.height - 1) / grid.area.height);
  for (int j = 0; j < grid.rows; j += step) {
    const PlotArea cell = grid.cellAt(0, j);
    drawFlushRight(image, grid.area.left - 12, cell.top + (cell.height - text) / 2 + 2,
                   kPlotFaint, labels[static_cast<std::size_t>(j)]);
  }
}

}  // namespace

Image drawHeatMap(const HeatMap& map, PictureSize size) {
  requireSound(map, size);
  Image image(size.width, size.height);
  const int head = drawHeading(image, map.title, map.subtitle);
  const Range range = rangeOf(map);

  const int text = textHeight(kPlotTextScale);
  const int bar_room =
      std::max(textWidth(map.value_label, kPlotTextScale), kBarWidth + 110) + 2 * kPad;
  PlotArea area;
  area.left = 130;
  area.top = head + text + 16;
  area.width = size.width - area.left - bar_room;
  area.height = size.height - area.top - 2 * text - 34 - kPad;
  const CellGrid grid{area, static_cast<int>(map.x.size()), static_cast<int>(map.y.size())};
  drawCells(image, grid, map, range);
  frame(image, {area.left - 2, area.top - 2, area.width + 4, area.height + 4}, 2, kPlotFaint);
  drawColumnLabels(image, grid, tickLabels(map.x));
  drawRowLabels(image, grid, tickLabels(map.y));
  drawCentred(image, area.left + area.width / 2, area.bottom() + 12 + text + 12, kPlotInk,
              map.x_label);
  drawText(image, area.left, area.top - text - 8, kPlotTextScale, kPlotInk, map.y_label);
  drawBar(image, {area.right() + 2 * kPad, area.top, kBarWidth, area.height}, map.value_label,
          range.low, range.high);
  return image;
}

}  // namespace handgraft::client::render
