#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

namespace handgraft::geometry {

/// Balls around points, parents around their children, so that many points can be passed over
/// at once.
class BallTree {
 public:
  BallTree() = default;

  /// `order` becomes the order in which ranges name the points. Shapes: points 3 x N. Ties are
  /// kept in order. Cost: O(N log^2 N).
  BallTree(const Eigen::Matrix3Xd& points, std::vector<int>& order);

  /// Calls `visit(begin, end)` for ranges of points in no ball that `passes(centre, radius)`.
  template <class Passes, class Visit>
  void visit(const Passes& passes, const Visit& visit) const {
    for (std::size_t i = 0; i < nodes_.size();) {
      const Node& node = nodes_[i];
      if (passes(node.centre, node.radius)) {
        i = node.next;
        continue;
      }
      if (node.end > node.begin) visit(node.begin, node.end);
      ++i;
    }
  }

  /// The ball around all points. Errors: BrokenContract if there is none.
  [[nodiscard]] const Eigen::Vector3d& centre() const;
  [[nodiscard]] double radius() const;

 private:
  /// Parents stand before their children; leaves alone have points.
  struct Node {
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    double radius = 0.0;
    int begin = 0;
    int end = 0;
    std::size_t next = 0;  ///< behind all that lies below
  };

  void build(const Eigen::Matrix3Xd& points, std::vector<int>& order, int begin, int end);

  std::vector<Node> nodes_;
};

}  // namespace handgraft::geometry
