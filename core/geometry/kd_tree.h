#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

namespace handgraft::geometry {

/// Nearest point of a fixed set (nanoflann). Const queries may run on several threads; ties go
/// to the lowest index, so answers do not depend on the build.
class KdTree {
 public:
  /// Shapes: points 3 x N, N >= 1, finite (InvalidInput otherwise). Keeps a copy.
  explicit KdTree(Eigen::Matrix3Xd points);
  ~KdTree();
  KdTree(KdTree&&) noexcept;
  KdTree& operator=(KdTree&&) noexcept;

  struct Hit {
    int index = -1;
    double distance = 0.0;
  };

  /// Errors: InvalidInput if `p` is not finite. Cost: O(log N).
  [[nodiscard]] Hit nearest(const Eigen::Vector3d& p) const;

  /// The nearest `count` points, or all if there are fewer, by rising distance, then index.
  /// Errors: InvalidInput if `p` is not finite; `count` >= 1. Cost: O(count log N).
  [[nodiscard]] std::vector<Hit> nearestFew(const Eigen::Vector3d& p, int count) const;

  /// The points no farther than `radius` >= 0 from `p`, by rising distance, then index.
  /// Errors: InvalidInput if `p` is not finite. Cost: O(log N) and what is found.
  [[nodiscard]] std::vector<Hit> within(const Eigen::Vector3d& p, double radius) const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

}  // namespace handgraft::geometry
