#include "client/present/render/plot.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/present/render/plot_parts.h"
#include "core/base/error.h"

namespace handgraft::client::render {
namespace {

using testing::ElementsAre;

constexpr Color kRed{255, 0, 0};

/// Rows of the topmost and the lowest pixel of a colour in a column; -1 if there is none.
std::pair<int, int> rowsOf(const Image& image, int column, Color color) {
  std::pair<int, int> rows{-1, -1};
  for (int y = 0; y < image.height(); ++y) {
    if (!(image.at(column, y) == color)) continue;
    if (rows.first < 0) rows.first = y;
    rows.second = y;
  }
  return rows;
}

int countOf(const Image& image, Color color) {
  int count = 0;
  for (const Color& pixel : image.pixels())
    count += pixel == color ? 1 : 0;
  return count;
}

Plot plotOf(std::vector<double> x, std::vector<double> y) {
  PlotLine line;
  line.x = std::move(x);
  line.y = std::move(y);
  line.color = kRed;
  line.width = 3.0;
  return {"title", "", "x", {{"y", {line}, std::nullopt, 1.0}}};
}

TEST(RoundTicks, CoverTheirRangeInRoundSteps) {
  EXPECT_THAT(roundTicks(0.0, 10.0, 5), ElementsAre(0, 2, 4, 6, 8, 10));
  EXPECT_THAT(roundTicks(0.5, 1.6, 6), testing::SizeIs(testing::Le(8)));
  for (const auto& [low, high] :
       {std::pair(0.5, 1.6), {-3.2, 0.1}, {1e-5, 7e-5}, {90., 9100.}}) {
    const std::vector<double> ticks = roundTicks(low, high, 6);
    EXPECT_LE(ticks.front(), low + 1e-9 * high);
    EXPECT_GE(ticks.back(), high - 1e-6 * std::abs(high));
    EXPECT_GT(ticks.size(), 2u);
  }
}

TEST(TickLabels, HaveTheDecimalsOfTheirSteps) {
  EXPECT_THAT(tickLabels({0.0, 2.0, 4.0}), ElementsAre("0", "2", "4"));
  EXPECT_THAT(tickLabels({0.0, 0.25, 0.5}), ElementsAre("0.00", "0.25", "0.50"));
  EXPECT_THAT(tickLabels({-0.5, 0.0, 0.5}), ElementsAre("-0.5", "0.0", "0.5"));
}

TEST(Plot, RisesWithItsValues) {
  const Image image = drawPlot(plotOf({0, 1}, {0, 10}), {600, 400});
  const auto left = rowsOf(image, 160, kRed);
  const auto right = rowsOf(image, 500, kRed);
  ASSERT_GE(left.first, 0);
  ASSERT_GE(right.first, 0);
  EXPECT_GT(left.first, right.second + 50) << "larger values lie higher";
}

TEST(Plot, LeavesAGapWhereAValueIsMissing) {
  const double nothing = std::numeric_limits<double>::quiet_NaN();
  const Image whole = drawPlot(plotOf({0, 1, 2, 3, 4}, {1, 1, 1, 1, 1}), {600, 400});
  const Image gap = drawPlot(plotOf({0, 1, 2, 3, 4}, {1, 1, nothing, 1, 1}), {600, 400});
  int missing = 0;
  for (int x = 0; x < 600; ++x)
    missing += rowsOf(whole, x, kRed).first >= 0 && rowsOf(gap, x, kRed).first < 0 ? 1 : 0;
  EXPECT_NEAR(missing, 0.5 * countOf(whole, kRed) / 3, 30) << "two of four pieces";
}

TEST(Plot, NamesALineOfTwoPanelsOnce) {
  Plot plot = plotOf({0, 1}, {0, 1});
  plot.panels[0].lines[0].name = "mean";
  const int one = countOf(drawPlot(plot, {900, 600}), {38, 42, 48});
  plot.panels.push_back(plot.panels[0]);
  plot.panels[1].label = "";
  const int two = countOf(drawPlot(plot, {900, 600}), {38, 42, 48});
  EXPECT_EQ(one, two) << "ink of title, labels and legend";
}

/// Pixels of names beside a panel with so many lines called the same, all of which end alike.
int inkBeside(std::size_t lines, bool at_ends) {
  Plot plot = plotOf({0, 1}, {0, 0});
  plot.panels[0].names_at_ends = at_ends;
  plot.panels[0].lines[0].name = "joint";
  plot.panels[0].lines.resize(lines, plot.panels[0].lines[0]);
  const Image image = drawPlot(plot, {900, 900});
  int ink = 0;
  for (int y = 0; y < image.height(); ++y)
    for (int x = 800; x < image.width(); ++x)
      ink += image.at(x, y) == kPlotInk ? 1 : 0;
  return ink;
}

TEST(Plot, NamesAtEndsDoNotOverlap) {
  const int one = inkBeside(1, true);
  EXPECT_GT(one, 0);
  EXPECT_EQ(inkBeside(1, false), one) << "the same name in a legend";
  EXPECT_EQ(inkBeside(24, true), 24 * one);
}

TEST(Plot, NamesAtEndsStandWhereLinesEnd) {
  Plot plot = plotOf({0, 1}, {10, 0});
  plot.panels[0].names_at_ends = true;
  plot.panels[0].lines[0].name = "falls";
  plot.panels[0].lines.push_back(plot.panels[0].lines[0]);
  plot.panels[0].lines[1].y = {0, 10};
  plot.panels[0].lines[1].name = "-";  // less ink
  const Image image = drawPlot(plot, {900, 900});
  int upper = 0;
  int lower = 0;
  for (int y = 0; y < image.height(); ++y)
    for (int x = 800; x < image.width(); ++x)
      if (image.at(x, y) == kPlotInk) ++(y < 450 ? upper : lower);
  EXPECT_GT(upper, 0);
  EXPECT_GT(lower, 2 * upper);
}

TEST(Plot, DrawsNothingButAxesWithoutValues) {
  EXPECT_EQ(countOf(drawPlot(plotOf({}, {}), {600, 400}), kRed), 0);
}

TEST(Plot, RefusesWhatItCannotDraw) {
  EXPECT_THROW(drawPlot({"none", "", "", {}}), InvalidInput);
  EXPECT_THROW(drawPlot(plotOf({0, 1}, {0})), InvalidInput);
  EXPECT_THROW(drawPlot(plotOf({0, 1}, {0, 1}), {200, 200}), InvalidInput);
}

TEST(HeatMap, IsDarkWhereLittleIs) {
  HeatMap map{"title", "", "x", "y", "value", {0, 1}, {0, 1}, {{0, 1}, {2, 3}}};
  const Image image = drawHeatMap(map, {900, 600});
  const auto light = [](Color c) {
    return c.r + c.g + c.b;
  };
  // Left of the cells' middles, where no number stands.
  const Color low = image.at(150, 480);
  const Color high = image.at(680, 120);
  EXPECT_LT(light(low) + 100, light(high));
  map.values[0][0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(drawHeatMap(map, {900, 600}).at(150, 480), (Color{255, 255, 255})) << "empty";
}

TEST(HeatMap, FramesTheLeastOrWhatItIsTold) {
  HeatMap map{"title", "", "x", "y", "value", {0, 1}, {0, 1}, {{0, 1}, {2, 3}}};
  const auto whites = [&map](int left, int top) {
    const Image image = drawHeatMap(map, {900, 600});
    int count = 0;
    for (int y = top; y < top + 200; ++y)
      for (int x = left; x < left + 200; ++x)
        if (image.at(x, y) == Color{255, 255, 255}) ++count;
    return count;
  };
  const int of_least = whites(140, 320);  // bottom left
  map.framed = {1, 1};
  EXPECT_LT(whites(140, 320), of_least) << "another cell is framed";
}

TEST(HeatMap, RefusesRowsOfAnotherLength) {
  EXPECT_THROW(drawHeatMap({"t", "", "x", "y", "v", {0, 1}, {0}, {{0}}}), InvalidInput);
  EXPECT_THROW(drawHeatMap({"t", "", "x", "y", "v", {}, {}, {}}), InvalidInput);
}

}  // namespace
}  // namespace handgraft::client::render
