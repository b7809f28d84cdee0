#include "client/present/render/plot_parts.h"

#include <algorithm>
#include <cmath>

#include "client/present/render/text.h"

namespace handgraft::client::render {

namespace {

constexpr int kPad = 24;

double distanceToSegment(PlotPoint p, PlotPoint a, PlotPoint b) {
  const double dx = b.x - a.x;
  const double dy = b.y - a.y;
  const double length2 = dx * dx + dy * dy;
  const double along =
      length2 > 0.0 ? std::clamp(((p.x - a.x) * dx + (p.y - a.y) * dy) / length2, 0.0, 1.0)
                    : 0.0;
  return std::hypot(p.x - a.x - along * dx, p.y - a.y - along * dy);
}

/// How much of each pixel of an area is covered.
class Cover {
 public:
  explicit Cover(const PlotArea& area)
      : area_(area),
        shares_(static_cast<std::size_t>(area.width) * static_cast<std::size_t>(area.height)) {}

  void add(PlotPoint a, PlotPoint b, double radius) {
    const auto clamped = [](double value, int low, int high) {
      return static_cast<int>(std::clamp<double>(value, low, high));
    };
    const double reach = radius + 1.0;
    const int left = clamped(std::min(a.x, b.x) - reach, area_.left, area_.right());
    const int right = clamped(std::max(a.x, b.x) + reach + 1.0, area_.left, area_.right());
    const int top = clamped(std::min(a.y, b.y) - reach, area_.top, area_.bottom());
    const int bottom = clamped(std::max(a.y, b.y) + reach + 1.0, area_.top, area_.bottom());
    for (int y = top; y < bottom; ++y) {
      for (int x = left; x < right; ++x) {
        const double distance = distanceToSegment({x + 0.5, y + 0.5}, a, b);
        float& share = shareAt(x, y);
        share =
            std::max(share, static_cast<float>(std::clamp(radius + 0.5 - distance, 0.0, 1.0)));
      }
    }
  }

  void paint(Image& image, Color color) {
    for (int y = area_.top; y < area_.bottom(); ++y) {
      for (int x = area_.left; x < area_.right(); ++x) {
        const double share = shareAt(x, y);
        if (share > 0.0) image.at(x, y) = blend(image.at(x, y), color, share);
      }
    }
  }

 private:
  float& shareAt(int x, int y) {
    return shares_[static_cast<std::size_t>(y - area_.top) *
                       static_cast<std::size_t>(area_.width) +
                   static_cast<std::size_t>(x - area_.left)];
  }

  PlotArea area_;
  std::vector<float> shares_;
};

}  // namespace

PlotScale::PlotScale(double from, double to, double first_pixel, double last_pixel)
    : from_(from),
      first_pixel_(first_pixel),
      pixels_per_unit_((last_pixel - first_pixel) / (to - from)) {}

double PlotScale::operator()(double value) const {
  return first_pixel_ + (value - from_) * pixels_per_unit_;
}

void drawPolyline(Image& image,
                  const PlotArea& area,
                  const std::vector<PlotPoint>& points,
                  double width,
                  Color color) {
  Cover cover(area);
  for (std::size_t i = 0; i + 1 < points.size(); ++i)
    cover.add(points[i], points[i + 1], 0.5 * width);
  cover.paint(image, color);
}

void drawDot(Image& image, const PlotArea& area, PlotPoint centre, double radius, Color color) {
  const int reach = static_cast<int>(radius) + 2;
  PlotArea around;
  around.left = std::max(area.left, static_cast<int>(centre.x) - reach);
  around.top = std::max(area.top, static_cast<int>(centre.y) - reach);
  around.width = std::min(area.right(), static_cast<int>(centre.x) + reach) - around.left;
  around.height = std::min(area.bottom(), static_cast<int>(centre.y) + reach) - around.top;
  if (around.width <= 0 || around.height <= 0) return;
  Cover cover(around);
  cover.add(centre, centre, radius);
  cover.paint(image, color);
}

void drawCentred(Image& image, int x, int y, Color color, const std::string& text) {
  drawText(image, x - textWidth(text, kPlotTextScale) / 2, y, kPlotTextScale, color, text);
}

void drawFlushRight(Image& image, int x, int y, Color color, const std::string& text) {
  drawText(image, x - textWidth(text, kPlotTextScale), y, kPlotTextScale, color, text);
}

namespace {

/// In as many lines as it takes; where the next one goes.
int drawLines(Image& image, int y, int scale, Color color, const std::string& text) {
  const int room = image.width() - 2 * kPad;
  std::string line;
  const auto finish = [&] {
    if (line.empty()) return;
    drawText(image, kPad, y, scale, color, line);
    y += textHeight(scale) + 10;
    line.clear();
  };
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find(' ', at), text.size());
    const std::string word = text.substr(at, end - at);
    const std::string longer = line.empty() ? word : line + " " + word;
    if (textWidth(longer, scale) > room) {
      finish();
      line = word;
    } else {
      line = longer;
    }
    at = end + 1;
  }
  finish();
  return y;
}

}  // namespace

int drawHeading(Image& image, const std::string& title, const std::string& subtitle) {
  const int y = drawLines(image, kPad, kPlotTitleScale, kPlotInk, title);
  return drawLines(image, y, kPlotTextScale, kPlotFaint, subtitle);
}

}  // namespace handgraft::client::render
