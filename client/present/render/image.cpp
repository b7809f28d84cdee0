#include "client/present/render/image.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/error.h"

namespace handgraft::client::render {

namespace {

constexpr int kLargestSide = 16384;

std::uint8_t mix(std::uint8_t under, std::uint8_t over, double opacity) {
  return static_cast<std::uint8_t>(std::lround(under + (over - under) * opacity));
}

int checkedSide(int side, const char* name) {
  if (side < 1 || side > kLargestSide) {
    rejectInput("image {}: {} pixels; it lies in 1-{}", name, side, kLargestSide);
  }
  return side;
}

}  // namespace

Color blend(const Color& under, const Color& over, double opacity) {
  const double share = std::clamp(opacity, 0.0, 1.0);
  return {mix(under.r, over.r, share), mix(under.g, over.g, share),
          mix(under.b, over.b, share)};
}

Image::Image(int width, int height, Color fill)
    : width_(checkedSide(width, "width")),
      height_(checkedSide(height, "height")),
      pixels_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), fill) {}

const Color& Image::at(int x, int y) const {
  HANDGRAFT_REQUIRE(x >= 0 && x < width_ && y >= 0 && y < height_);
  return pixels_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                 static_cast<std::size_t>(x)];
}

Color& Image::at(int x, int y) {
  return const_cast<Color&>(std::as_const(*this).at(x, y));
}

void Image::fill(int x, int y, int width, int height, Color color) {
  const int right = std::min(x + width, width_);
  const int bottom = std::min(y + height, height_);
  for (int row = std::max(y, 0); row < bottom; ++row) {
    for (int column = std::max(x, 0); column < right; ++column)
      at(column, row) = color;
  }
}

}  // namespace handgraft::client::render
