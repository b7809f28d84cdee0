#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "client/present/render/image.h"
#include "client/present/render/two_views.h"

namespace handgraft::client::render {

/// A curve through points in the order of `x`; it is broken where a value is not finite.
struct PlotLine {
  std::vector<double> x;
  std::vector<double> y;
  Color color;
  double width = 2.0;  ///< pixels
  bool dots = false;   ///< one at every point
  std::string name;    ///< in the legend or at its end; empty: nowhere
};

/// One set of axes.
struct PlotPanel {
  std::string label;  ///< of y, with its unit
  std::vector<PlotLine> lines;
  std::optional<std::pair<double, double>> range;  ///< of y; nothing: what the lines need
  double height = 1.0;                             ///< share, against the other panels'
  /// Names stand beside the ends of their lines, not in the legend: for many of like colours.
  bool names_at_ends = false;
};

/// Pixels that a name at the end of a line takes; where a panel is lower than all of its names,
/// they begin above it.
int plotNameHeight();

/// Panels above each other over one x axis, with a legend of all of them beside.
struct Plot {
  std::string title;
  std::string subtitle;
  std::string x_label;
  std::vector<PlotPanel> panels;
};

/// Draws axes, ticks at round numbers, grid, lines and legend. Lines lie in the order given,
/// the last on top; a name that several panels have is in the legend once. Errors: InvalidInput
/// for a plot without panels, a line whose x and y differ in length, and a side below 300
/// pixels.
Image drawPlot(const Plot& plot, PictureSize size = {});

/// Values over two quantities. `values[j][i]` belongs to y[j] and x[i]; values that are not
/// finite leave their cell empty.
struct HeatMap {
  std::string title;
  std::string subtitle;
  std::string x_label;
  std::string y_label;
  std::string value_label;
  std::vector<double> x;
  std::vector<double> y;
  std::vector<std::vector<double>> values;
  /// Column and row of the cell that is framed; nothing: that of the least value.
  std::optional<std::pair<std::size_t, std::size_t>> framed = std::nullopt;
};

/// Draws a cell a value, y rising, one of them framed, with a bar of colours beside.
/// Errors: InvalidInput for no values, rows of another length, and a side below 300 pixels.
Image drawHeatMap(const HeatMap& map, PictureSize size = {});

/// Up to ten colours that can be told apart; they begin anew after that.
Color plotColor(std::size_t index);

/// Round numbers that cover [low, high] or a little more in at most `most` steps.
std::vector<double> roundTicks(double low, double high, int most);

/// Numbers as tick labels: as many decimals as their steps need, all alike.
std::vector<std::string> tickLabels(const std::vector<double>& ticks);

}  // namespace handgraft::client::render
