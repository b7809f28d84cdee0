#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "client/present/render/camera.h"

namespace handgraft::client::render {

/// Which thing is nearest at each sample of a picture, and how near it is. Sample (x, y) lies
/// at the middle of its square, (x + 0.5, y + 0.5).
class DepthBuffer {
 public:
  static constexpr std::uint32_t kNothing = 0xFFFFFFFFU;

  DepthBuffer(int width, int height);

  /// Covers the samples inside the triangle, of either orientation. Triangles that share an
  /// edge cover each sample along it exactly once (top-left rule on coordinates rounded to
  /// 1/256 sample). Without effect if a coordinate is not finite or beyond 2^20 samples.
  /// True if it is now the nearest at some sample.
  bool drawTriangle(const std::array<ScreenPoint, 3>& corners, std::uint32_t id);

  /// Covers the samples within half the width of the segment (round ends).
  void drawSegment(const ScreenPoint& from,
                   const ScreenPoint& to,
                   float width,
                   std::uint32_t id);

  [[nodiscard]] int width() const { return width_; }

  [[nodiscard]] int height() const { return height_; }

  [[nodiscard]] std::uint32_t idAt(int x, int y) const { return samples_[index(x, y)].id; }

  [[nodiscard]] float nearnessAt(int x, int y) const { return samples_[index(x, y)].nearness; }

 private:
  struct Sample {
    float nearness;
    std::uint32_t id;
  };

  [[nodiscard]] std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
           static_cast<std::size_t>(x);
  }

  int width_;
  int height_;
  std::vector<Sample> samples_;
};

}  // namespace handgraft::client::render
