#include "core/geometry/kd_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <nanoflann.hpp>

#include "core/base/error.h"

namespace handgraft::geometry {

namespace {

Eigen::Matrix3Xd checked(Eigen::Matrix3Xd points) {
  if (points.cols() == 0) rejectInput("point set has 0 points, at least 1 is needed");
  if (points.cols() > std::numeric_limits<int>::max()) {
    rejectInput("point set has {} points, at most {} are permitted", points.cols(),
                std::numeric_limits<int>::max());
  }
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    if (!points.col(i).allFinite()) {
      rejectInput("point {} is ({}, {}, {}), coordinates must be finite", i, points(0, i),
                  points(1, i), points(2, i));
    }
  }
  return points;
}

void requireFinite(const Eigen::Vector3d& p) {
  if (!p.allFinite()) {
    rejectInput("query point is ({}, {}, {}), coordinates must be finite", p[0], p[1], p[2]);
  }
}

struct Points {
  Eigen::Matrix3Xd columns;

  // NOLINTBEGIN(readability-identifier-naming): names that nanoflann asks for
  [[nodiscard]] std::size_t kdtree_get_point_count() const {
    return static_cast<std::size_t>(columns.cols());
  }

  [[nodiscard]] double kdtree_get_pt(std::size_t index, std::size_t axis) const {
    return columns(static_cast<Eigen::Index>(axis), static_cast<Eigen::Index>(index));
  }

  template <class Box>
  bool kdtree_get_bbox(Box& box) const {
    for (int axis = 0; axis < 3; ++axis) {
      box[axis].low = columns.row(axis).minCoeff();
      box[axis].high = columns.row(axis).maxCoeff();
    }
    return true;
  }

  // NOLINTEND(readability-identifier-naming)
};

/// The nearest point, the lowest index among equals. nanoflann offers only points strictly
/// nearer than `worstDist`, so that is one step above the best: equals are offered, too.
class LowestIndexNearest {
 public:
  using DistanceType = double;

  bool addPoint(double distance_squared, std::size_t index) {
    if (distance_squared < best_ || (distance_squared == best_ && index < index_)) {
      best_ = distance_squared;
      index_ = index;
    }
    return true;
  }

  [[nodiscard]] double worstDist() const {
    return std::nextafter(best_, std::numeric_limits<double>::infinity());
  }

  [[nodiscard]] bool full() const { return true; }

  [[nodiscard]] std::size_t size() const { return 1; }

  [[nodiscard]] KdTree::Hit hit() const { return {static_cast<int>(index_), std::sqrt(best_)}; }

  [[nodiscard]] bool empty() const { return index_ == kNone; }

 private:
  static constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
  double best_ = std::numeric_limits<double>::max();
  std::size_t index_ = kNone;
};

/// Of squared distances and indices, in their order.
std::vector<KdTree::Hit> hitsOf(const std::vector<std::pair<double, std::size_t>>& found) {
  std::vector<KdTree::Hit> hits;
  hits.reserve(found.size());
  for (const auto& [distance_squared, index] : found)
    hits.push_back({static_cast<int>(index), std::sqrt(distance_squared)});
  return hits;
}

/// The nearest few, by (distance, index); equals of the farthest are offered, as above.
class LowestIndicesNearest {
 public:
  using DistanceType = double;

  explicit LowestIndicesNearest(std::size_t count) : count_(count) { best_.reserve(count + 1); }

  bool addPoint(double distance_squared, std::size_t index) {
    const std::pair found(distance_squared, index);
    best_.insert(std::upper_bound(best_.begin(), best_.end(), found), found);
    if (best_.size() > count_) best_.pop_back();
    return true;
  }

  [[nodiscard]] double worstDist() const {
    if (!full()) return std::numeric_limits<double>::max();
    return std::nextafter(best_.back().first, std::numeric_limits<double>::infinity());
  }

  [[nodiscard]] bool full() const { return best_.size() == count_; }

  [[nodiscard]] std::size_t size() const { return best_.size(); }

  [[nodiscard]] std::vector<KdTree::Hit> hits() const { return hitsOf(best_); }

 private:
  std::size_t count_;
  std::vector<std::pair<double, std::size_t>> best_;
};

/// All within a radius, by (distance, index).
class AllWithin {
 public:
  using DistanceType = double;

  explicit AllWithin(double radius)
      : reach_squared_(
            std::nextafter(radius * radius, std::numeric_limits<double>::infinity())) {}

  bool addPoint(double distance_squared, std::size_t index) {
    found_.emplace_back(distance_squared, index);
    return true;
  }

  [[nodiscard]] double worstDist() const { return reach_squared_; }

  [[nodiscard]] bool full() const { return true; }

  [[nodiscard]] std::size_t size() const { return found_.size(); }

  [[nodiscard]] std::vector<KdTree::Hit> hits() {
    std::sort(found_.begin(), found_.end());
    return hitsOf(found_);
  }

 private:
  double reach_squared_;
  std::vector<std::pair<double, std::size_t>> found_;
};

using Index = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Points>,
                                                  Points,
                                                  3,
                                                  std::size_t>;

}  // namespace

struct KdTree::Tree {
  explicit Tree(Eigen::Matrix3Xd columns)
      : points{checked(std::move(columns))}, index(3, points) {}

  Points points;
  Index index;
};

KdTree::KdTree(Eigen::Matrix3Xd points) : tree_(std::make_unique<Tree>(std::move(points))) {}

KdTree::~KdTree() = default;
KdTree::KdTree(KdTree&&) noexcept = default;
KdTree& KdTree::operator=(KdTree&&) noexcept = default;

KdTree::Hit KdTree::nearest(const Eigen::Vector3d& p) const {
  requireFinite(p);
  LowestIndexNearest result;
  tree_->index.findNeighbors(result, p.data(), nanoflann::SearchParams());
  if (result.empty()) {
    rejectInput("query point is ({}, {}, {}), too far from the points", p[0], p[1], p[2]);
  }
  return result.hit();
}

std::vector<KdTree::Hit> KdTree::nearestFew(const Eigen::Vector3d& p, int count) const {
  requireFinite(p);
  HANDGRAFT_REQUIRE(count >= 1);
  LowestIndicesNearest result(static_cast<std::size_t>(count));
  tree_->index.findNeighbors(result, p.data(), nanoflann::SearchParams());
  return result.hits();
}

std::vector<KdTree::Hit> KdTree::within(const Eigen::Vector3d& p, double radius) const {
  requireFinite(p);
  HANDGRAFT_REQUIRE(radius >= 0.0);
  AllWithin result(radius);
  tree_->index.findNeighbors(result, p.data(), nanoflann::SearchParams());
  return result.hits();
}

}  // namespace handgraft::geometry
