#include "core/geometry/ball_tree.h"

#include <algorithm>
#include <numeric>

#include <Eigen/Geometry>

#include "core/base/error.h"

namespace handgraft::geometry {

namespace {

constexpr int kLeafPoints = 6;

}  // namespace

BallTree::BallTree(const Eigen::Matrix3Xd& points, std::vector<int>& order) {
  order.resize(static_cast<std::size_t>(points.cols()));
  std::iota(order.begin(), order.end(), 0);
  if (!order.empty()) build(points, order, 0, static_cast<int>(order.size()));
}

const Eigen::Vector3d& BallTree::centre() const {
  HANDGRAFT_REQUIRE(!nodes_.empty());
  return nodes_.front().centre;
}

double BallTree::radius() const {
  HANDGRAFT_REQUIRE(!nodes_.empty());
  return nodes_.front().radius;
}

void BallTree::build(const Eigen::Matrix3Xd& points,
                     std::vector<int>& order,
                     int begin,
                     int end) {
  const std::size_t index = nodes_.size();
  nodes_.emplace_back();
  Eigen::AlignedBox3d box;
  for (int i = begin; i < end; ++i)
    box.extend(points.col(order[static_cast<std::size_t>(i)]));
  Node node;
  node.centre = box.center();
  for (int i = begin; i < end; ++i)
    node.radius = std::max(
        node.radius, (points.col(order[static_cast<std::size_t>(i)]) - node.centre).norm());
  if (end - begin > kLeafPoints) {
    int axis = 0;
    box.sizes().maxCoeff(&axis);
    std::stable_sort(order.begin() + begin, order.begin() + end, [&](int a, int b) {
      return points(axis, a) < points(axis, b);
    });
    const int middle = begin + (end - begin) / 2;
    build(points, order, begin, middle);
    build(points, order, middle, end);
  } else {
    node.begin = begin;
    node.end = end;
  }
  node.next = nodes_.size();
  nodes_[index] = node;
}

}  // namespace handgraft::geometry
