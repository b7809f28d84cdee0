#include "client/present/render/depth_buffer.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/error.h"

namespace handgraft::client::render {

namespace {

constexpr std::int64_t kSubsamples = 256;      // per side of a sample
constexpr float kFarthestSample = 1048576.0F;  // 2^20: edge functions then fit 62 bits

struct GridPoint {
  std::int64_t x;
  std::int64_t y;
};

bool isDrawable(const ScreenPoint& p) {
  return std::abs(p.x) <= kFarthestSample && std::abs(p.y) <= kFarthestSample &&
         std::isfinite(p.nearness);  // comparisons with NaN are false
}

// Rounds to the grid. The shift makes all numbers positive, where a cast rounds down; a call of
// llround takes a tenth of a picture's time.
std::int64_t roundToGrid(float value) {
  constexpr std::int64_t kShift = 1LL << 30;
  return static_cast<std::int64_t>(static_cast<double>(value) * kSubsamples + (kShift + 0.5)) -
         kShift;
}

GridPoint onGrid(const ScreenPoint& p) {
  return {roundToGrid(p.x), roundToGrid(p.y)};
}

// Twice the signed area of (a, b, p): positive where p lies to the right of the edge on a
// screen whose y axis points down.
std::int64_t edge(const GridPoint& a, const GridPoint& b, const GridPoint& p) {
  return (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
}

// Edges that own the samples lying exactly on them, of a triangle with positive area.
bool isTopOrLeft(const GridPoint& a, const GridPoint& b) {
  return (a.y == b.y && b.x > a.x) || b.y < a.y;
}

std::int64_t floorDivide(std::int64_t a, std::int64_t b) {
  return a >= 0 ? a / b : -((-a + b - 1) / b);
}

}  // namespace

DepthBuffer::DepthBuffer(int width, int height) : width_(width), height_(height) {
  HANDGRAFT_REQUIRE(width > 0 && height > 0);
  samples_.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height),
                  {-std::numeric_limits<float>::infinity(), kNothing});
}

bool DepthBuffer::drawTriangle(const std::array<ScreenPoint, 3>& corners, std::uint32_t id) {
  if (!isDrawable(corners[0]) || !isDrawable(corners[1]) || !isDrawable(corners[2]))
    return false;
  std::array<GridPoint, 3> p = {onGrid(corners[0]), onGrid(corners[1]), onGrid(corners[2])};
  std::array<float, 3> nearness = {corners[0].nearness, corners[1].nearness,
                                   corners[2].nearness};
  std::int64_t area = edge(p[0], p[1], p[2]);
  if (area == 0) return false;
  if (area < 0) {
    std::swap(p[1], p[2]);
    std::swap(nearness[1], nearness[2]);
    area = -area;
  }

  // === Samples whose middles lie in the bounding box
  const auto [left, right] = std::minmax({p[0].x, p[1].x, p[2].x});
  const auto [top, bottom] = std::minmax({p[0].y, p[1].y, p[2].y});
  constexpr std::int64_t kHalf = kSubsamples / 2;
  const auto x_begin = std::max<std::int64_t>(0, floorDivide(left - kHalf, kSubsamples));
  const auto x_end =
      std::min<std::int64_t>(width_, floorDivide(right - kHalf, kSubsamples) + 1);
  const auto y_begin = std::max<std::int64_t>(0, floorDivide(top - kHalf, kSubsamples));
  const auto y_end =
      std::min<std::int64_t>(height_, floorDivide(bottom - kHalf, kSubsamples) + 1);
  if (x_begin >= x_end || y_begin >= y_end) return false;

  // === Edge functions: value at the first sample, steps to its neighbours
  const GridPoint first = {x_begin * kSubsamples + kHalf, y_begin * kSubsamples + kHalf};
  std::array<std::int64_t, 3> row{};
  std::array<std::int64_t, 3> step_x{};
  std::array<std::int64_t, 3> step_y{};
  for (std::size_t k = 0; k < 3; ++k) {
    const GridPoint& a = p[(k + 1) % 3];  // edge k lies opposite to corner k
    const GridPoint& b = p[(k + 2) % 3];
    row[k] = edge(a, b, first) - (isTopOrLeft(a, b) ? 0 : 1);
    step_x[k] = -(b.y - a.y) * kSubsamples;
    step_y[k] = (b.x - a.x) * kSubsamples;
  }
  const double scale = 1.0 / static_cast<double>(area);
  const double slope_1 = static_cast<double>(nearness[1]) - static_cast<double>(nearness[0]);
  const double slope_2 = static_cast<double>(nearness[2]) - static_cast<double>(nearness[0]);

  bool seen = false;
  for (std::int64_t y = y_begin; y < y_end; ++y) {
    std::array<std::int64_t, 3> value = row;
    Sample* sample = &samples_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                               static_cast<std::size_t>(x_begin)];
    for (std::int64_t x = x_begin; x < x_end; ++x, ++sample) {
      if ((value[0] | value[1] | value[2]) >= 0) {
        const auto near =
            static_cast<float>(nearness[0] + scale * (slope_1 * static_cast<double>(value[1]) +
                                                      slope_2 * static_cast<double>(value[2])));
        if (near > sample->nearness) {
          *sample = {near, id};
          seen = true;
        }
      }
      for (std::size_t k = 0; k < 3; ++k)
        value[k] += step_x[k];
    }
    for (std::size_t k = 0; k < 3; ++k)
      row[k] += step_y[k];
  }
  return seen;
}

void DepthBuffer::drawSegment(const ScreenPoint& from,
                              const ScreenPoint& to,
                              float width,
                              std::uint32_t id) {
  if (!isDrawable(from) || !isDrawable(to) || !(width > 0.0F)) return;
  const float radius = 0.5F * std::min(width, 4096.0F);
  const auto clamp_to = [](float value, int limit) {
    return static_cast<int>(std::clamp(value, 0.0F, static_cast<float>(limit)));
  };
  const int x_begin = clamp_to(std::floor(std::min(from.x, to.x) - radius), width_);
  const int x_end = clamp_to(std::ceil(std::max(from.x, to.x) + radius), width_);
  const int y_begin = clamp_to(std::floor(std::min(from.y, to.y) - radius), height_);
  const int y_end = clamp_to(std::ceil(std::max(from.y, to.y) + radius), height_);
  const float dx = to.x - from.x;
  const float dy = to.y - from.y;
  const float length_squared = dx * dx + dy * dy;
  for (int y = y_begin; y < y_end; ++y) {
    for (int x = x_begin; x < x_end; ++x) {
      const float qx = static_cast<float>(x) + 0.5F - from.x;
      const float qy = static_cast<float>(y) + 0.5F - from.y;
      const float along = length_squared > 0.0F
                              ? std::clamp((qx * dx + qy * dy) / length_squared, 0.0F, 1.0F)
                              : 0.0F;
      const float off_x = qx - along * dx;
      const float off_y = qy - along * dy;
      if (off_x * off_x + off_y * off_y > radius * radius) continue;
      const float near = from.nearness + along * (to.nearness - from.nearness);
      Sample& sample = samples_[index(x, y)];
      if (near > sample.nearness) sample = {near, id};
    }
  }
}

}  // namespace handgraft::client::render
