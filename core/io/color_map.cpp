#include "core/io/color_map.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <map>
#include <utility>

#include "core/base/error.h"

namespace handgraft::io {
namespace {

/// Knots at equal steps, as 0xRRGGBB.
ColorMap evenly(const char* name, std::initializer_list<std::uint32_t> colors) {
  ColorMap map;
  map.name = name;
  map.rgb.resize(3, static_cast<Eigen::Index>(colors.size()));
  Eigen::Index k = 0;
  for (const std::uint32_t color : colors) {
    map.at.push_back(static_cast<double>(k) / static_cast<double>(colors.size() - 1));
    map.rgb.col(k++) << (color >> 16U & 0xFFU) / 255.0, (color >> 8U & 0xFFU) / 255.0,
        (color & 0xFFU) / 255.0;
  }
  return map;
}

const std::vector<ColorMap>& all() {
  static const std::vector<ColorMap> known_maps = [] {
    std::vector<ColorMap> maps;
    maps.push_back(evenly("grey", {0x000000, 0xFFFFFF}));
    // Black body: red fills, then green, then blue.
    ColorMap hot{"hot", {0.0, 0.375, 0.75, 1.0}, Eigen::Matrix3Xd(3, 4)};
    hot.rgb << 0, 1, 1, 1,  //
        0, 0, 1, 1,         //
        0, 0, 0, 1;
    maps.push_back(std::move(hot));
    maps.push_back(
        evenly("inferno", {0x000004, 0x160B39, 0x420A68, 0x6A176E, 0x932667, 0xBC3754, 0xDD513A,
                           0xF37819, 0xFCA50A, 0xF6D746, 0xFCFFA4}));
    // Each channel is a trapezium of slope 4 about 3/4, 1/2 and 1/4.
    ColorMap jet{"jet", {0.0, 0.125, 0.375, 0.625, 0.875, 1.0}, Eigen::Matrix3Xd(3, 6)};
    jet.rgb << 0, 0, 0, 1, 1, 0.5,  //
        0, 0, 1, 1, 0, 0,           //
        0.5, 1, 1, 0, 0, 0;
    maps.push_back(std::move(jet));
    maps.push_back(
        evenly("viridis", {0x440154, 0x482576, 0x414487, 0x35608D, 0x2A788E, 0x21908D, 0x22A884,
                           0x43BF71, 0x7AD151, 0xBBDF27, 0xFDE725}));
    return maps;
  }();
  return known_maps;
}

ColorValues valuesWithoutCheck(const ColorMap& map, const Eigen::Matrix3Xd& rgb) {
  ColorValues values;
  values.value.resize(rgb.cols());
  for (Eigen::Index i = 0; i < rgb.cols(); ++i) {
    const ColorValue found = valueOfColor(map, rgb.col(i));
    values.value[i] = found.value;
    values.mean_residual += found.residual / static_cast<double>(rgb.cols());
    values.largest_residual = std::max(values.largest_residual, found.residual);
  }
  return values;
}

/// And how far off the colours are on average.
std::pair<const ColorMap*, double> nearestScale(const Eigen::Matrix3Xd& rgb) {
  std::pair<const ColorMap*, double> best{nullptr, std::numeric_limits<double>::infinity()};
  for (const ColorMap& map : all()) {
    const double residual = valuesWithoutCheck(map, rgb).mean_residual;
    if (residual < best.second) best = {&map, residual};
  }
  return best;
}

}  // namespace

const ColorMap& colorMap(const std::string& name) {
  const std::string wanted = name == "gray" ? "grey" : name;
  for (const ColorMap& map : all()) {
    if (map.name == wanted) return map;
  }
  rejectInput("colour map {}: there are {}", quoted(name), fmt::join(colorMapNames(), ", "));
}

std::vector<std::string> colorMapNames() {
  std::vector<std::string> names;
  for (const ColorMap& map : all())
    names.push_back(map.name);
  return names;
}

Eigen::Vector3d colorOf(const ColorMap& map, double value) {
  const double v = std::clamp(value, 0.0, 1.0);
  std::size_t k = 1;
  while (k + 1 < map.at.size() && map.at[k] < v)
    ++k;
  const double t = (v - map.at[k - 1]) / (map.at[k] - map.at[k - 1]);
  const auto column = static_cast<Eigen::Index>(k);
  return (1.0 - t) * map.rgb.col(column - 1) + t * map.rgb.col(column);
}

ColorValue valueOfColor(const ColorMap& map, const Eigen::Vector3d& rgb) {
  ColorValue best{0.0, std::numeric_limits<double>::infinity()};
  for (std::size_t k = 1; k < map.at.size(); ++k) {
    const auto column = static_cast<Eigen::Index>(k);
    const Eigen::Vector3d a = map.rgb.col(column - 1);
    const Eigen::Vector3d d = map.rgb.col(column) - a;
    const double t = std::clamp((rgb - a).dot(d) / d.squaredNorm(), 0.0, 1.0);
    const double residual = (a + t * d - rgb).norm();
    if (residual >= best.residual) continue;
    best = {map.at[k - 1] + t * (map.at[k] - map.at[k - 1]), residual};
  }
  return best;
}

ColorValues valuesOfColors(const ColorMap& map, const Eigen::Matrix3Xd& rgb) {
  ColorValues values = valuesWithoutCheck(map, rgb);
  if (values.mean_residual <= kLargestMeanResidual) return values;
  const auto [best, least] = nearestScale(rgb);
  rejectInput(
      "the colours are not those of '{}': they lie {:.2f} from it on average, permitted is "
      "{:.2f}; the nearest scale is '{}' at {:.2f}",
      map.name, values.mean_residual, kLargestMeanResidual, best->name, least);
}

std::string describeColors(const Eigen::Matrix3Xd& rgb) {
  constexpr int kSteps = 8;  // of each channel: what eyes would call one colour
  constexpr std::size_t kMostNamed = 4;

  struct Bin {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    int count = 0;
  };

  std::map<int, Bin> bins;
  for (Eigen::Index i = 0; i < rgb.cols(); ++i) {
    int key = 0;
    for (const double channel : rgb.col(i)) {
      const int step = static_cast<int>(std::clamp(channel, 0.0, 1.0) * kSteps);
      key = key * kSteps + std::min(step, kSteps - 1);
    }
    bins[key].sum += rgb.col(i);
    ++bins[key].count;
  }
  std::vector<Bin> ranked;
  ranked.reserve(bins.size());
  for (const auto& [key, bin] : bins)
    ranked.push_back(bin);
  std::stable_sort(ranked.begin(), ranked.end(), [](const Bin& a, const Bin& b) {
    return a.count > b.count;
  });
  ranked.resize(std::min(ranked.size(), kMostNamed));
  std::string text;
  for (const Bin& bin : ranked) {
    const Eigen::Vector3d mean = 255.0 * bin.sum / bin.count;
    text += fmt::format("{}#{:02x}{:02x}{:02x} {:.0f} %", text.empty() ? "" : ", ",
                        std::lround(mean[0]), std::lround(mean[1]), std::lround(mean[2]),
                        100.0 * bin.count / static_cast<double>(rgb.cols()));
  }
  const auto [best, least] = nearestScale(rgb);
  return fmt::format("{}; nearest is the scale '{}', {:.2f} off on average", text, best->name,
                     least);
}

}  // namespace handgraft::io
