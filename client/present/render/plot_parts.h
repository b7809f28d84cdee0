#pragma once

#include <string>
#include <vector>

#include "client/present/render/image.h"

/// What plots are drawn with; plot.h and its two kinds of pictures use it.
namespace handgraft::client::render {

inline constexpr int kPlotTitleScale = 3;
inline constexpr int kPlotTextScale = 2;
inline constexpr Color kPlotInk{38, 42, 48};
inline constexpr Color kPlotFaint{105, 112, 122};
inline constexpr Color kPlotGrid{228, 231, 236};

/// A rectangle of pixels.
struct PlotArea {
  int left = 0;
  int top = 0;
  int width = 0;
  int height = 0;

  [[nodiscard]] int right() const { return left + width; }

  [[nodiscard]] int bottom() const { return top + height; }
};

/// Values to pixels, linearly; `from` and `to` must differ.
class PlotScale {
 public:
  PlotScale(double from, double to, double first_pixel, double last_pixel);

  [[nodiscard]] double operator()(double value) const;

 private:
  double from_;
  double first_pixel_;
  double pixels_per_unit_;
};

/// Places in pixels, fractions of them too.
struct PlotPoint {
  double x = 0.0;
  double y = 0.0;
};

/// Draws a polyline with soft edges within `area`; opacity does not add up where it bends.
void drawPolyline(Image& image,
                  const PlotArea& area,
                  const std::vector<PlotPoint>& points,
                  double width,
                  Color color);

/// A filled disc with a soft edge.
void drawDot(Image& image, const PlotArea& area, PlotPoint centre, double radius, Color color);

/// Text about `x` in the middle; to the left of `x`.
void drawCentred(Image& image, int x, int y, Color color, const std::string& text);
void drawFlushRight(Image& image, int x, int y, Color color, const std::string& text);

/// Title and subtitle at the top; returns the first row below them.
int drawHeading(Image& image, const std::string& title, const std::string& subtitle);

}  // namespace handgraft::client::render
