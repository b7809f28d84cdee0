#pragma once

#include <complex>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "core/geometry/heat_source.h"
#include "core/geometry/intrinsic_delaunay.h"

namespace handgraft::geometry {

/// Scalars, tangent vectors and positions diffused over one connected manifold surface for a
/// time of its squared mean edge.
class HeatFlow {
 public:
  /// Factors the scalar and the connection operator. Keeps a reference to `mesh`. Errors:
  /// InvalidInput of IntrinsicDelaunay.
  explicit HeatFlow(const TriangleMesh& mesh);
  ~HeatFlow();
  HeatFlow(const HeatFlow&) = delete;
  HeatFlow& operator=(const HeatFlow&) = delete;

  [[nodiscard]] const IntrinsicDelaunay& surface() const { return surface_; }

  /// The mean edge after the flips, metres: how far heat spreads.
  [[nodiscard]] double unitLength() const { return unit_length_; }

  /// Log coordinates in T of every vertex that a face within `radius` of the source has,
  /// metres; NaN elsewhere and where no heat arrives. `origin` is where the source stands in
  /// the mesh's frame. Cost: grows with the disk and its ancestors in the elimination tree,
  /// plus O(F).
  [[nodiscard]] Eigen::Matrix2Xd affineLog(const std::vector<HeatSeed>& seeds,
                                           const Eigen::Vector3d& origin,
                                           double radius) const;
  /// The same by the vector heat method, of all vertices.
  [[nodiscard]] Eigen::Matrix2Xd vectorLog(const std::vector<HeatSeed>& seeds) const;

 private:
  struct Edge;
  struct Factors;

  [[nodiscard]] Eigen::VectorXcd vectorLogFrom(const HeatSeed& seed) const;
  [[nodiscard]] Eigen::VectorXcd parallelField(const std::vector<HeatSeed>& seeds,
                                               const std::vector<char>& wanted) const;
  [[nodiscard]] std::vector<char> verticesNear(const Eigen::Vector3d& origin,
                                               double radius) const;

  const TriangleMesh& mesh_;
  IntrinsicDelaunay surface_;
  double unit_length_ = 1.0;  ///< mean edge, metres; everything inside is measured in it
  std::vector<Edge> edges_;
  std::unique_ptr<Factors> factors_;
};

}  // namespace handgraft::geometry
