#include "tests/bench/accuracy.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <optional>
#include <random>

#include "core/base/error.h"
#include "core/geometry/heat_log_map.h"

namespace handgraft::bench {

namespace {

using geometry::LogMap;
using geometry::LogMapMethod;
using geometry::SurfacePoint;
using geometry::TriangleMesh;

constexpr double kAtSource = 1e-9;  // m

/// Sums up what Accuracy holds means of.
class Sum {
 public:
  void add(const LogMap& map, const PolarTruth& truth, double radius) {
    ++accuracy_.maps;
    accuracy_.exact_maps += map.method == LogMapMethod::kExact ? 1 : 0;
    std::vector<double> turns;
    std::complex<double> heading;
    for (int v = 0; v < truth.r.size(); ++v) {
      if (truth.r[v] < kAtSource || truth.r[v] > radius) continue;
      if (std::isnan(map.r[v])) {
        // What lies on the rim may be outside by rounding.
        accuracy_.missing += truth.r[v] < (1.0 - kRim) * radius ? 1 : 0;
        continue;
      }
      const double error = std::abs(map.r[v] / truth.r[v] - 1.0);
      r_sum_ += error;
      accuracy_.r_max = std::max(accuracy_.r_max, error);
      ++accuracy_.compared;
      if (std::isnan(truth.phi[v])) continue;
      turns.push_back(map.phi[v] - truth.phi[v]);
      heading += std::polar(1.0, turns.back());
    }
    if (turns.empty()) return;
    // One rotation about the source: its mean, without a seam.
    double mean = 0.0;
    for (double& turn : turns) {
      turn = std::remainder(turn - std::arg(heading), 2.0 * std::numbers::pi);
      mean += turn;
    }
    mean /= static_cast<double>(turns.size());
    for (const double turn : turns) {
      const double error = std::abs(turn - mean);
      phi_sum_ += error;
      accuracy_.phi_max = std::max(accuracy_.phi_max, error);
    }
    phi_count_ += static_cast<long long>(turns.size());
  }

  void refuse(const std::string& reason) { accuracy_.refusal = reason; }

  [[nodiscard]] Accuracy accuracy(const std::string& source) const {
    Accuracy result = accuracy_;
    result.source = source;
    if (result.compared > 0) result.r_mean = r_sum_ / static_cast<double>(result.compared);
    if (phi_count_ > 0) result.phi_mean = phi_sum_ / static_cast<double>(phi_count_);
    return result;
  }

 private:
  static constexpr double kRim = 0.01;

  Accuracy accuracy_;
  double r_sum_ = 0.0;
  double phi_sum_ = 0.0;
  long long phi_count_ = 0;
};

struct KindOfSource {
  const char* name;
  Eigen::Vector3d barycentric;
};

std::vector<SurfacePoint> drawSources(const MeasuredSurface& surface,
                                      const Eigen::Vector3d& barycentric) {
  std::mt19937 random(3);
  std::vector<SurfacePoint> sources;
  while (sources.size() < kSourcesOfAKind) {
    const auto faces = static_cast<unsigned>(surface.mesh.faceCount());
    const SurfacePoint source{static_cast<int>(random() % faces), barycentric};
    if (surface.may_start(positionOf(surface.mesh, source))) sources.push_back(source);
  }
  return sources;
}

}  // namespace

std::vector<Accuracy> measureAccuracy(const MeasuredSurface& surface, LogMapMethod method) {
  const TriangleMesh& mesh = surface.mesh;
  std::optional<geometry::HeatLogMap> heat;
  if (method == LogMapMethod::kSmooth || method == LogMapMethod::kHeat) heat.emplace(mesh);
  const KindOfSource kinds[] = {
      {"vertex", {0.0, 0.0, 1.0}}, {"face", {0.2, 0.5, 0.3}}, {"edge", {0.0, 0.4, 0.6}}};
  std::vector<Accuracy> result;
  Sum all;
  for (const KindOfSource& kind : kinds) {
    Sum sum;
    for (const SurfacePoint& source : drawSources(surface, kind.barycentric)) {
      const Eigen::Vector3d direction = normalOf(mesh, source).unitOrthogonal();
      const double radius = surface.radius(source);
      try {
        const LogMap map = method == LogMapMethod::kSmooth
                               ? heat->smooth(source, direction, radius)
                           : method == LogMapMethod::kHeat
                               ? heat->heat(source, direction, radius)
                               : computeLogMap(mesh, source, direction, radius, method);
        const PolarTruth truth = surface.truth(source);
        sum.add(map, truth, radius);
        all.add(map, truth, radius);
      } catch (const InvalidInput& error) {
        sum.refuse(error.what());
        all.refuse(error.what());
      }
    }
    result.push_back(sum.accuracy(kind.name));
  }
  result.push_back(all.accuracy("all"));
  return result;
}

}  // namespace handgraft::bench
