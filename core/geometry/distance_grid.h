#pragma once

#include <algorithm>
#include <memory>
#include <vector>

#include <Eigen/Geometry>

#include "core/base/progress.h"
#include "core/geometry/signed_distance.h"

namespace handgraft::geometry {

struct DistanceGridOptions {
  double least_spacing_m = 5e-4;
  /// The spacing grows until so many nodes hold the mesh and its margin; 1000 to 16 million.
  int most_nodes = 300000;
};

/// A signed distance on a grid, for loops: some 30 ns a query, with a slope that a solver can
/// follow.
///
/// Value and gradient are those of one quadratic B-spline, once continuously differentiable
/// everywhere inside the grid. Nodes within two spacings of the surface are exact; between
/// others, every third one is. The spline rounds edges and ridges by about half a spacing; on
/// smooth surfaces it is off by h^2 / 8 times their summed curvature (h = 1.5 mm on a ball of
/// 30 mm: 0.02 mm).
/// Const and safe from several threads.
class DistanceGrid {
 public:
  /// `values`: those of such a grid of the same before, which are believed if they are as many
  /// and finite. Errors: InvalidInput on options out of range; Cancelled on wish. Cost: O(N) of
  /// nodes, 0.1 to 0.3 s by default, little with values; 4 bytes a node.
  DistanceGrid(std::shared_ptr<const SignedDistance> exact,
               const DistanceGridOptions& options,
               const Progress& progress,
               std::vector<float> values = {});

  /// The smoothed distance. Outside the box a lower bound of it, positive.
  [[nodiscard]] double at(const Eigen::Vector3d& p) const;

  /// Also the gradient; zero outside the box, where nobody is inside anything.
  [[nodiscard]] double at(const Eigen::Vector3d& p, Eigen::Vector3d& gradient) const;

  /// No more than the exact distance at p: that of nodes about it that lie outside, less the
  /// way there; minus infinity if none does. 0 outside the box. Cost: some 60 ns.
  [[nodiscard]] double atLeast(const Eigen::Vector3d& p) const;

  /// Nothing within `radius` of p lies inside; a no may be one for want of a closer look.
  /// Cost: one node.
  [[nodiscard]] bool isClear(const Eigen::Vector3d& p, double radius) const {
    const Eigen::Vector3d u = (p - origin_) * per_spacing_;
    for (int a = 0; a < 3; ++a)
      if (!(u[a] > 0.0 && u[a] < counts_[a] - 1)) return at(p) > radius;
    const Eigen::Vector3i nearest = (u.array() + 0.5).cast<int>();
    return values_[indexOf(nearest)] > radius + kDoubt * spacing_;
  }

  /// How far p can move at least before `at` says less than `least`: below 0 where it does so
  /// at p. Who is told more than `enough` is told some of it only. Cost: one node where p is
  /// far, else `at`.
  [[nodiscard]] double clearance(const Eigen::Vector3d& p, double least, double enough) const {
    const Eigen::Vector3d u = (p - origin_) * per_spacing_;
    for (int a = 0; a < 3; ++a)
      if (!(u[a] > 0.0 && u[a] < counts_[a] - 1)) return at(p) - kDoubt * spacing_ - least;
    const Eigen::Vector3i nearest = (u.array() + 0.5).cast<int>();
    const double bound = values_[indexOf(nearest)] - kDoubt * spacing_ - least;
    if (bound > enough) return bound;
    return std::max(bound, (at(p) - least) / kSteepest);
  }

  /// No gradient of `at` is longer than that: of a distance it is 1; the spline's was 1.28 at
  /// most, beside edges, where nodes are blended.
  static constexpr double kSteepest = 1.4;

  [[nodiscard]] double spacing() const { return spacing_; }

  [[nodiscard]] const SignedDistance& exact() const { return *exact_; }

  /// What it took long to find.
  [[nodiscard]] const std::vector<float>& values() const { return values_; }

  /// The middle of one cell of the grid, and how much of the cell is solid, in (0, 1].
  struct Cell {
    Eigen::Vector3d p;
    double share = 0.0;
  };

  /// The cells about nodes that are partly or wholly inside, in a fixed order.
  [[nodiscard]] std::vector<Cell> solidCells() const;

 private:
  /// Spacings by which a node's value may differ from the distance at the places next to it:
  /// 0.87 for the way there, and as much for what is blended far from the surface.
  static constexpr double kDoubt = 2.0;

  [[nodiscard]] std::size_t valueCount() const;
  void fill(const Progress& progress);
  void fillCoarse(const Progress& progress);
  [[nodiscard]] double fineValueAt(const Eigen::Vector3i& node) const;
  [[nodiscard]] double signOf(const Eigen::Vector3i& node,
                              double distance,
                              int step,
                              const std::vector<float>& known) const;
  [[nodiscard]] Eigen::Vector3d place(const Eigen::Vector3i& node) const;

  /// What `take(stencil, weights of x, y, z)` makes of the nodes about p; outside the box a
  /// lower bound of the distance.
  template <class Take>
  inline double look(const Eigen::Vector3d& p, const Take& take) const;

  [[nodiscard]] std::size_t indexOf(const Eigen::Vector3i& node) const {
    return (static_cast<std::size_t>(node[2]) * static_cast<std::size_t>(counts_[1]) +
            static_cast<std::size_t>(node[1])) *
               static_cast<std::size_t>(counts_[0]) +
           static_cast<std::size_t>(node[0]);
  }

  std::shared_ptr<const SignedDistance> exact_;
  double spacing_ = 0.0;
  double per_spacing_ = 0.0;
  Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();  ///< of node 0, 0, 0
  Eigen::Vector3i counts_ = Eigen::Vector3i::Zero();
  Eigen::AlignedBox3d box_;  ///< where stencils are whole
  std::vector<float> values_;
};

}  // namespace handgraft::geometry
