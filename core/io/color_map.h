#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

namespace handgraft::io {

/// A colour scale by which a picture shows numbers: a curve in RGB, straight between knots.
///
/// `grey`, `hot` and `jet` are straight by definition, so exact. `inferno` and `viridis` are
/// given by their colours at every tenth, which puts them within 0.02 of the full scale.
struct ColorMap {
  std::string name;
  std::vector<double> at;  ///< rising from 0 to 1
  Eigen::Matrix3Xd rgb;    ///< each in [0, 1], a column per knot
};

/// By name: grey (or gray), hot, inferno, jet, viridis. Errors: InvalidInput naming it and what
/// there is.
const ColorMap& colorMap(const std::string& name);

std::vector<std::string> colorMapNames();

/// The colour of a value, clamped to [0, 1].
Eigen::Vector3d colorOf(const ColorMap& map, double value);

struct ColorValue {
  double value = 0.0;     ///< in [0, 1]
  double residual = 0.0;  ///< distance in RGB between the colour and the curve; up to sqrt(3)
};

/// The value whose colour is nearest. Shapes: rgb in [0, 1]. Cost: O(knots).
ColorValue valueOfColor(const ColorMap& map, const Eigen::Vector3d& rgb);

/// Values of many colours, and how well the map explains them all.
struct ColorValues {
  Eigen::VectorXd value;
  double mean_residual = 0.0;
  double largest_residual = 0.0;
};

/// Shapes: rgb 3 x N in [0, 1]. Errors: InvalidInput if the mean residual is above
/// kLargestMeanResidual: then the picture was made with another scale; the message names the
/// scale that fits best.
ColorValues valuesOfColors(const ColorMap& map, const Eigen::Matrix3Xd& rgb);

/// What colours there are, and which scale is nearest to them all, in words: "#000004 62 %,
/// #dd513a 9 %; nearest is the scale 'inferno', 0.02 off on average". Shapes: as above.
std::string describeColors(const Eigen::Matrix3Xd& rgb);

/// A third of the way across the cube would pass for any scale; a tenth leaves room for
/// compression, shading and blurred seams.
inline constexpr double kLargestMeanResidual = 0.1;

}  // namespace handgraft::io
