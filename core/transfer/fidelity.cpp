#include "core/transfer/fidelity.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Geometry>

#include <fmt/format.h>

#include "core/base/angle.h"

namespace handgraft::transfer {
namespace {

constexpr double kShortestEdge = 1e-3;      // of the net's longest
constexpr double kThinnestTriangle = 0.05;  // height over the longest side
constexpr double kMuchOfLength = 0.15;
constexpr double kMuchAngle = 0.262;  // rad

using Triangle = std::array<const NetKnot*, 3>;

/// A mean by weights, and the greatest.
class Spread {
 public:
  void add(double value, double weight) {
    sum_ += weight * value;
    weight_ += weight;
    max_ = std::max(max_, value);
  }

  [[nodiscard]] double mean() const { return weight_ > 0.0 ? sum_ / weight_ : 0.0; }

  [[nodiscard]] double max() const { return max_; }

 private:
  double sum_ = 0.0;
  double weight_ = 0.0;
  double max_ = 0.0;
};

double lengthOn(Eigen::Vector3d NetKnot::*p, const NetKnot& a, const NetKnot& b) {
  return (b.*p - a.*p).norm();
}

double areaOn(Eigen::Vector3d NetKnot::*p, const Triangle& t) {
  return 0.5 * (t[1]->*p - t[0]->*p).cross(t[2]->*p - t[0]->*p).norm();
}

double angleOn(Eigen::Vector3d NetKnot::*p, const Triangle& t, int corner) {
  const Eigen::Vector3d a = t[(corner + 1) % 3]->*p - t[corner]->*p;
  const Eigen::Vector3d b = t[(corner + 2) % 3]->*p - t[corner]->*p;
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

class NetComparison {
 public:
  explicit NetComparison(const std::vector<std::vector<NetKnot>>& rows) {
    forEdges(rows, [&](const NetKnot& a, const NetKnot& b) {
      longest_ = std::max(longest_, lengthOn(&NetKnot::p_O, a, b));
    });
    forEdges(rows, [&](const NetKnot& a, const NetKnot& b) {
      addEdge(a, b);
    });
    for (std::size_t r = 0; r + 1 < rows.size(); ++r) {
      for (std::size_t i = 0; i < rows[r].size(); ++i) {
        const std::size_t j = (i + 1) % rows[r].size();
        addTriangle({&rows[r][i], &rows[r + 1][i], &rows[r + 1][j]});
        addTriangle({&rows[r][i], &rows[r + 1][j], &rows[r][j]});
      }
    }
  }

  [[nodiscard]] Fidelity result() const {
    Fidelity fidelity;
    fidelity.distance_mean = lengths_.mean();
    fidelity.distance_max = lengths_.max();
    fidelity.angle_mean_rad = angles_.mean();
    fidelity.angle_max_rad = angles_.max();
    if (area_O_ > 0.0) fidelity.area_ratio = area_S_ / area_O_;
    return fidelity;
  }

 private:
  template <class Visit>
  static void forEdges(const std::vector<std::vector<NetKnot>>& rows, const Visit& visit) {
    const auto offer = [&](const NetKnot& a, const NetKnot& b) {
      if (a.valid && b.valid) visit(a, b);
    };
    for (std::size_t r = 0; r < rows.size(); ++r) {
      for (std::size_t i = 0; i < rows[r].size(); ++i) {
        offer(rows[r][i], rows[r][(i + 1) % rows[r].size()]);
        if (r + 1 < rows.size()) offer(rows[r][i], rows[r + 1][i]);
      }
    }
  }

  void addEdge(const NetKnot& a, const NetKnot& b) {
    const double length = lengthOn(&NetKnot::p_O, a, b);
    if (!(length > kShortestEdge * longest_)) return;
    lengths_.add(std::abs(lengthOn(&NetKnot::p_S, a, b) / length - 1.0), length);
  }

  void addTriangle(const Triangle& t) {
    if (!t[0]->valid || !t[1]->valid || !t[2]->valid) return;
    const double area = areaOn(&NetKnot::p_O, t);
    area_O_ += area;
    area_S_ += areaOn(&NetKnot::p_S, t);
    double longest = 0.0;
    for (int c = 0; c < 3; ++c)
      longest = std::max(longest, lengthOn(&NetKnot::p_O, *t[c], *t[(c + 1) % 3]));
    if (!(2.0 * area > kThinnestTriangle * longest * longest)) return;
    for (int c = 0; c < 3; ++c) {
      angles_.add(std::abs(angleOn(&NetKnot::p_S, t, c) - angleOn(&NetKnot::p_O, t, c)), area);
    }
  }

  double longest_ = 0.0;
  Spread lengths_;
  Spread angles_;
  double area_O_ = 0.0;
  double area_S_ = 0.0;
};

}  // namespace

Fidelity fidelityOf(const std::vector<std::vector<NetKnot>>& rows) {
  return NetComparison(rows).result();
}

std::string distortionOf(const Fidelity& fidelity) {
  if (fidelity.distance_mean < kMuchOfLength && fidelity.angle_mean_rad < kMuchAngle) return {};
  return fmt::format("lengths {:.0f} %, angles {:.0f} deg, area x {:.2f}",
                     100.0 * fidelity.distance_mean, inDegrees(fidelity.angle_mean_rad),
                     fidelity.area_ratio);
}

}  // namespace handgraft::transfer
