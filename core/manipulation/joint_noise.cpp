#include "core/manipulation/joint_noise.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace handgraft::manipulation {

namespace {

constexpr double kFine = 0.0003;    // m; less moves no finger that is seen
constexpr std::size_t kFewest = 5;  // of three unknowns
constexpr int kCoordinates = hand::JointPlaces::SizeAtCompileTime;
constexpr double kWidest = 0.06;  // s; a hand closes in some 300 ms

std::vector<hand::JointPlaces> inObject(const std::vector<DemonstratedFrame>& frames) {
  std::vector<hand::JointPlaces> joints_O;
  joints_O.reserve(frames.size());
  for (const DemonstratedFrame& frame : frames)
    joints_O.emplace_back(frame.X_WO.inverse() * frame.joints_W.colwise().homogeneous());
  return joints_O;
}

// Over many frames a bell of s of them leaves 1 / sqrt(2 sqrt(pi) s) of the noise in a mean,
// and of the middle of a parabola sqrt(27 / 16) times as much.
constexpr double kLeft = 27.0 / 16.0 / (2.0 * 1.7724538509055159);  // squared, times s

double stepOf(const std::vector<DemonstratedFrame>& frames) {
  return (frames.back().time_s - frames.front().time_s) /
         static_cast<double>(frames.size() - 1);
}

}  // namespace

double jointNoise(const std::vector<DemonstratedFrame>& frames) {
  constexpr std::size_t kFewestFrames = 16;
  if (frames.size() < kFewestFrames) return 0.0;
  const std::vector<hand::JointPlaces> joints_O = inObject(frames);
  std::vector<double> differences;
  for (std::size_t k = 4; k < joints_O.size(); ++k) {
    const hand::JointPlaces fourth = joints_O[k] - 4.0 * joints_O[k - 1] +
                                     6.0 * joints_O[k - 2] - 4.0 * joints_O[k - 3] +
                                     joints_O[k - 4];
    for (const double value : fourth.reshaped())
      differences.push_back(std::abs(value));
  }
  const auto middle = differences.begin() + static_cast<std::ptrdiff_t>(differences.size() / 2);
  std::nth_element(differences.begin(), middle, differences.end());
  constexpr double kMedianOfNormal = 0.67449;
  const double gain = std::sqrt(1.0 + 16.0 + 36.0 + 16.0 + 1.0);
  return *middle / (kMedianOfNormal * gain);
}

EvenedFrames evenedOut(std::vector<DemonstratedFrame> frames, double noise_m) {
  if (noise_m <= kFine || frames.size() < kFewest) return {std::move(frames), noise_m};
  const double step_s = stepOf(frames);
  const double wanted = noise_m / kFine;
  const double width_s = std::min(kWidest, kLeft * wanted * wanted * step_s);
  const double reach_s = 3.0 * width_s;
  const std::vector<hand::JointPlaces> joints_O = inObject(frames);
  std::size_t first = 0;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    const double now_s = frames[k].time_s;
    while (frames[first].time_s < now_s - reach_s)
      ++first;
    // Least squares of c0 + c1 t + c2 t^2 about now, near frames before far ones: c0.
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Matrix<double, 3, kCoordinates> right = decltype(right)::Zero();
    std::size_t count = 0;
    for (std::size_t i = first; i < frames.size() && frames[i].time_s <= now_s + reach_s; ++i) {
      const double t = (frames[i].time_s - now_s) / width_s;
      const Eigen::Vector3d powers(1.0, t, t * t);
      const Eigen::Vector3d weighed = std::exp(-0.5 * t * t) * powers;
      normal += weighed * powers.transpose();
      right += weighed * joints_O[i].reshaped().transpose();
      ++count;
    }
    if (count < kFewest) continue;
    const Eigen::Matrix<double, 3, kCoordinates> fit = normal.ldlt().solve(right);
    const hand::JointPlaces even_O = fit.row(0).transpose().reshaped(3, kCoordinates / 3);
    frames[k].joints_W = frames[k].X_WO * even_O.colwise().homogeneous();
  }
  const double left_m = noise_m * std::min(1.0, std::sqrt(kLeft * step_s / width_s));
  return {std::move(frames), left_m};
}

}  // namespace handgraft::manipulation
