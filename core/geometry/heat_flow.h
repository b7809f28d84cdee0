#pragma once

#include <complex>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "core/geometry/intrinsic_delaunay.h"

namespace handgraft::geometry {

/// A vertex's share in a source, in that vertex's own tangent basis.
struct HeatSeed {
  int vertex = -1;
  double weight = 0.0;
  /// The source's x axis, seen from the vertex: a unit complex number.
  std::complex<double> axis = 1.0;
  /// Where the vertex stands in the source's tangent plane T, metres.
  std::complex<double> p_T = 0.0;
};

/// Scalars, tangent vectors and positions diffused over one connected manifold surface for a
/// time of its squared mean edge.
class HeatFlow {
 public:
  /// Factors the scalar and the connection operator. Errors: InvalidInput of IntrinsicDelaunay.
  explicit HeatFlow(const TriangleMesh& mesh);
  ~HeatFlow();
  HeatFlow(const HeatFlow&) = delete;
  HeatFlow& operator=(const HeatFlow&) = delete;

  [[nodiscard]] const IntrinsicDelaunay& surface() const { return surface_; }

  /// Log coordinates of every vertex in T, metres; NaN where no heat arrives.
  [[nodiscard]] Eigen::Matrix2Xd affineLog(const std::vector<HeatSeed>& seeds) const;
  /// The same by the vector heat method.
  [[nodiscard]] Eigen::Matrix2Xd vectorLog(const std::vector<HeatSeed>& seeds) const;

 private:
  struct Edge;
  struct Factors;

  [[nodiscard]] Eigen::VectorXcd vectorLogFrom(const HeatSeed& seed) const;
  [[nodiscard]] Eigen::VectorXcd parallelField(const std::vector<HeatSeed>& seeds) const;

  IntrinsicDelaunay surface_;
  double unit_length_ = 1.0;  ///< mean edge, metres; everything inside is measured in it
  std::vector<Edge> edges_;
  std::unique_ptr<Factors> factors_;
};

}  // namespace handgraft::geometry
