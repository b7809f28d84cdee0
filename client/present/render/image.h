#pragma once

#include <cstdint>
#include <vector>

namespace handgraft::client::render {

/// sRGB, 8 bits a channel.
struct Color {
  std::uint8_t r = 0;
  std::uint8_t g = 0;
  std::uint8_t b = 0;

  friend bool operator==(const Color&, const Color&) = default;
};

/// `over` laid on `under` with the given opacity in [0, 1].
Color blend(const Color& under, const Color& over, double opacity);

/// Pixels in rows from the top left; (0, 0) is the top left one.
class Image {
 public:
  /// Errors: InvalidInput unless both sides lie in 1-16384.
  Image(int width, int height, Color fill = {255, 255, 255});

  [[nodiscard]] int width() const { return width_; }

  [[nodiscard]] int height() const { return height_; }

  /// BrokenContract outside the image.
  [[nodiscard]] Color& at(int x, int y);
  [[nodiscard]] const Color& at(int x, int y) const;

  /// Fills a rectangle; what lies outside the image is cut off.
  void fill(int x, int y, int width, int height, Color color);

  /// Row-major pixels, three bytes each.
  [[nodiscard]] const std::vector<Color>& pixels() const { return pixels_; }

 private:
  int width_;
  int height_;
  std::vector<Color> pixels_;
};

}  // namespace handgraft::client::render
