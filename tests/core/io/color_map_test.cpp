#include "core/io/color_map.h"

#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"

namespace handgraft::io {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

class EveryColorMap : public ::testing::TestWithParam<std::string> {};

TEST_P(EveryColorMap, ComesBackFromItsOwnColours) {
  const ColorMap& map = colorMap(GetParam());
  for (int i = 0; i <= 1000; ++i) {
    const ColorValue found = valueOfColor(map, colorOf(map, i / 1000.0));
    EXPECT_NEAR(found.value, i / 1000.0, 1e-9);
    EXPECT_NEAR(found.residual, 0.0, 1e-12);
  }
}

TEST_P(EveryColorMap, ComesBackFromColoursOfEightBits) {
  const ColorMap& map = colorMap(GetParam());
  for (int i = 0; i <= 1000; ++i) {
    const Eigen::Vector3d rgb = (colorOf(map, i / 1000.0) * 255.0).array().round() / 255.0;
    const ColorValue found = valueOfColor(map, rgb);
    EXPECT_NEAR(found.value, i / 1000.0, 0.005);
    EXPECT_LE(found.residual, std::sqrt(3.0) / 510.0 + 1e-12);
  }
}

INSTANTIATE_TEST_SUITE_P(ColorMap, EveryColorMap, ::testing::ValuesIn(colorMapNames()));

TEST(ColorMap, HotAndJetAreTheirFormulas) {
  for (int i = 0; i <= 100; ++i) {
    const double v = i / 100.0;
    const auto ramp = [](double x) {
      return std::clamp(x, 0.0, 1.0);
    };
    const Eigen::Vector3d hot(ramp(8.0 / 3.0 * v), ramp(8.0 / 3.0 * v - 1.0),
                              ramp(4.0 * v - 3.0));
    EXPECT_LT((colorOf(colorMap("hot"), v) - hot).norm(), 1e-12) << v;
    const Eigen::Vector3d jet(ramp(1.5 - std::abs(4.0 * v - 3.0)),
                              ramp(1.5 - std::abs(4.0 * v - 2.0)),
                              ramp(1.5 - std::abs(4.0 * v - 1.0)));
    EXPECT_LT((colorOf(colorMap("jet"), v) - jet).norm(), 1e-12) << v;
  }
}

TEST(ColorMap, SaysHowFarAColourIsOff) {
  const ColorValue found = valueOfColor(colorMap("grey"), {0.5, 0.5, 0.8});
  EXPECT_NEAR(found.value, 0.6, 1e-12);
  EXPECT_NEAR(found.residual, Eigen::Vector3d(0.1, 0.1, -0.2).norm(), 1e-12);
}

TEST(ColorMap, NamesTheScaleThatFitsBetter) {
  Eigen::Matrix3Xd rgb(3, 101);
  for (int i = 0; i <= 100; ++i)
    rgb.col(i) = colorOf(colorMap("jet"), i / 100.0);
  EXPECT_THAT(
      [&] {
        valuesOfColors(colorMap("inferno"), rgb);
      },
      ThrowsMessage<InvalidInput>(
          AllOf(HasSubstr("not those of 'inferno'"), HasSubstr("nearest scale is 'jet'"))));
  EXPECT_LT(valuesOfColors(colorMap("jet"), rgb).largest_residual, 1e-12);
}

TEST(ColorMap, RefusesANameThatItDoesNotKnow) {
  EXPECT_EQ(&colorMap("gray"), &colorMap("grey"));
  EXPECT_THAT(
      [&] {
        colorMap("magma");
      },
      ThrowsMessage<InvalidInput>(HasSubstr("grey, hot, inferno, jet, viridis")));
}

}  // namespace
}  // namespace handgraft::io
