#include "core/cloud/prepared_cloud.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <tuple>
#include <unordered_map>
#include <utility>

#include <Eigen/Eigenvalues>

#include "core/base/error.h"
#include "core/cloud/reconstruction.h"
#include "core/cloud/roughness.h"
#include "core/geometry/kd_tree.h"

namespace handgraft::cloud {

namespace {

using geometry::KdTree;

constexpr int kNeighbours = 6;         // a ring of neighbours, as CGAL's average spacing has it
constexpr int kFittedNeighbours = 18;  // paraboloids: three rings' worth evens out noise
constexpr double kAgreeingShare = 0.9;
/// Thickness over length below which points are a plane: a sheet of 85 mm bulges 0.2 mm.
constexpr double kThinnest = 2e-3;

void requireFinite(const PointCloud& cloud) {
  for (Eigen::Index i = 0; i < cloud.points_O.cols(); ++i) {
    const auto p = cloud.points_O.col(i);
    if (!p.allFinite()) {
      rejectInput("point {} is ({}, {}, {}), coordinates must be finite", i, p[0], p[1], p[2]);
    }
  }
}

void requireEnough(Eigen::Index count, const char* what) {
  if (count < kFewestPoints) {
    rejectInput("point cloud has {} {}; a surface needs at least {}", count, what,
                kFewestPoints);
  }
}

/// Keeps the columns of `kept`, rising, of points and normals.
void keep(PointCloud& cloud, const std::vector<Eigen::Index>& kept) {
  cloud.points_O = Eigen::Matrix3Xd(cloud.points_O(Eigen::all, kept));
  if (cloud.normals_O.cols() > 0)
    cloud.normals_O = Eigen::Matrix3Xd(cloud.normals_O(Eigen::all, kept));
}

// === Cells of a grid

using Cell = std::array<std::int64_t, 3>;

struct CellHash {
  std::size_t operator()(const Cell& cell) const {
    std::uint64_t hash = 0;
    for (const std::int64_t c : cell)
      hash = (hash ^ static_cast<std::uint64_t>(c)) * 0x9E3779B97F4A7C15ull + (hash >> 29);
    return hash;
  }
};

Cell cellOf(const Eigen::Vector3d& p, const Eigen::Vector3d& low, double size) {
  Cell cell{};
  for (int axis = 0; axis < 3; ++axis)
    cell[axis] = static_cast<std::int64_t>(std::floor((p[axis] - low[axis]) / size));
  return cell;
}

std::vector<Eigen::Index> firstOfCells(const Eigen::Matrix3Xd& points, double size) {
  const Eigen::Vector3d low = points.rowwise().minCoeff();
  std::unordered_map<Cell, Eigen::Index, CellHash> first;
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 0; i < points.cols(); ++i)
    if (first.emplace(cellOf(points.col(i), low, size), i).second) kept.push_back(i);
  return kept;
}

// === Steps

void mergeEqual(PointCloud& cloud, std::vector<std::string>& notes) {
  const Eigen::Matrix3Xd& points = cloud.points_O;
  std::vector<Eigen::Index> order(static_cast<std::size_t>(points.cols()));
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  const auto key = [&](Eigen::Index i) {
    return std::tuple(points(0, i), points(1, i), points(2, i), i);
  };
  std::sort(order.begin(), order.end(), [&](Eigen::Index a, Eigen::Index b) {
    return key(a) < key(b);
  });
  const auto last =
      std::unique(order.begin(), order.end(), [&](Eigen::Index a, Eigen::Index b) {
        return points.col(a) == points.col(b);
      });
  if (last == order.end()) return;
  order.erase(last, order.end());
  std::sort(order.begin(), order.end());
  notes.push_back(fmt::format("merged {} points to {}", points.cols(), order.size()));
  keep(cloud, order);
}

void thin(PointCloud& cloud,
          int most,
          const Progress& progress,
          std::vector<std::string>& notes) {
  const Eigen::Index count = cloud.points_O.cols();
  if (count <= most) return;
  const std::vector<Eigen::Index> kept = evenSelection(cloud.points_O, most, progress);
  notes.push_back(fmt::format("thinned {} points to {}, evenly", count, kept.size()));
  keep(cloud, kept);
}

void requireSpace(const Eigen::Matrix3Xd& points) {
  const Eigen::Vector3d centre = points.rowwise().mean();
  const Eigen::Matrix3Xd arms = points.colwise() - centre;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(arms * arms.transpose());
  const Eigen::Matrix3Xd along = axes.eigenvectors().transpose() * arms;  // thinnest first
  const Eigen::Vector3d extent = along.rowwise().maxCoeff() - along.rowwise().minCoeff();
  if (!(extent[0] > kThinnest * extent[2])) {
    rejectInput(
        "point cloud is {:.4g} x {:.4g} x {:.4g} mm along its axes: a {}; its thickness must "
        "be "
        "above {} of its length",
        1e3 * extent[2], 1e3 * extent[1], 1e3 * extent[0],
        extent[1] > kThinnest * extent[2] ? "plane" : "line", kThinnest);
  }
}

struct Spread {
  double spacing = 0.0;  ///< mean over points of the mean distance of six neighbours
  double gap = 0.0;
  double unevenness = 1.0;
  Eigen::VectorXd reach;  ///< per point, distance of its sixth neighbour
};

Spread spreadOf(const Eigen::Matrix3Xd& points, const KdTree& tree, const Progress& progress) {
  Spread spread;
  spread.reach.resize(points.cols());
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    if (i % 4096 == 0) progress.checkpoint();
    const auto near = tree.nearestFew(points.col(i), kNeighbours + 1);  // itself first
    for (const KdTree::Hit& hit : near)
      spread.spacing += hit.distance / kNeighbours;
    spread.reach[i] = near.back().distance;
  }
  spread.spacing /= static_cast<double>(points.cols());
  // On evenly scattered points holes are up to three spacings wide; files of corners of CAD
  // faces have larger ones, which the widest neighbourhoods tell.
  std::vector<double> sorted(spread.reach.begin(), spread.reach.end());
  const auto widest = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() * 99 / 100);
  std::nth_element(sorted.begin(), widest, sorted.end());
  spread.gap = std::max(4.0 * spread.spacing, 2.0 * *widest);
  const double wide = *widest;
  const auto usual = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), usual, sorted.end());
  spread.unevenness = *usual > 0.0 ? wide / *usual : 1.0;
  return spread;
}

/// Piece of every point, numbered from 0: points in the same or touching cells hang together.
std::vector<int> piecesOf(const Eigen::Matrix3Xd& points, double gap) {
  const double size = 0.5 * gap;
  const Eigen::Vector3d low = points.rowwise().minCoeff();
  std::unordered_map<Cell, std::vector<Eigen::Index>, CellHash> cells;
  for (Eigen::Index i = 0; i < points.cols(); ++i)
    cells[cellOf(points.col(i), low, size)].push_back(i);
  std::vector<int> piece(static_cast<std::size_t>(points.cols()), -1);
  int count = 0;
  for (Eigen::Index first = 0; first < points.cols(); ++first) {
    if (piece[first] >= 0) continue;
    std::vector<Cell> open{cellOf(points.col(first), low, size)};
    for (const Eigen::Index i : cells[open.back()])
      piece[i] = count;
    while (!open.empty()) {
      const Cell cell = open.back();
      open.pop_back();
      for (int d = 0; d < 27; ++d) {
        const Cell other{cell[0] + d % 3 - 1, cell[1] + d / 3 % 3 - 1, cell[2] + d / 9 - 1};
        const auto found = cells.find(other);
        if (found == cells.end() || piece[found->second.front()] >= 0) continue;
        for (const Eigen::Index i : found->second)
          piece[i] = count;
        open.push_back(other);
      }
    }
    ++count;
  }
  return piece;
}

/// True if something was left out.
bool keepLargestPiece(PointCloud& cloud, double gap, std::vector<std::string>& notes) {
  const std::vector<int> piece = piecesOf(cloud.points_O, gap);
  std::vector<int> size;
  for (const int p : piece) {
    if (p >= std::ssize(size)) size.resize(static_cast<std::size_t>(p) + 1);
    ++size[p];
  }
  if (size.size() == 1) return false;
  const auto largest =
      static_cast<int>(std::max_element(size.begin(), size.end()) - size.begin());
  std::vector<Eigen::Index> kept;
  for (std::size_t i = 0; i < piece.size(); ++i)
    if (piece[i] == largest) kept.push_back(static_cast<Eigen::Index>(i));
  notes.push_back(fmt::format(
      "left out {} of {} points: {} separate pieces, farther than {:.2g} mm from the rest",
      piece.size() - kept.size(), piece.size(), size.size() - 1, 1e3 * gap));
  keep(cloud, kept);
  return true;
}

// === Normals

/// Unit length; zero where there was no direction.
Eigen::Matrix3Xd normalized(Eigen::Matrix3Xd normals) {
  for (Eigen::Index i = 0; i < normals.cols(); ++i) {
    const double length = normals.col(i).stableNorm();
    if (!(length > 1e-6 && length < 1e12)) {
      normals.col(i).setZero();
    } else {
      normals.col(i) /= length;
    }
  }
  return normals;
}

/// Share of points whose normal looks the way the nearest neighbours' ones do on average.
double agreementOf(const Eigen::Matrix3Xd& points,
                   const Eigen::Matrix3Xd& normals,
                   const KdTree& tree) {
  Eigen::Index agreeing = 0;
  Eigen::Index judged = 0;
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    if (normals.col(i).isZero()) continue;
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const KdTree::Hit& hit : tree.nearestFew(points.col(i), kNeighbours + 1))
      if (hit.index != i) mean += normals.col(hit.index);
    ++judged;
    if (mean.dot(normals.col(i)) > 0.0) ++agreeing;
  }
  return judged > 0 ? static_cast<double>(agreeing) / static_cast<double>(judged) : 0.0;
}

/// Turns all normals if, by the divergence theorem, they look into the whole.
void turnOutward(const Eigen::Matrix3Xd& points,
                 const Eigen::VectorXd& reach,
                 Eigen::Matrix3Xd& normals) {
  const Eigen::VectorXd area = reach.cwiseAbs2();  // what a point stands for
  const Eigen::Vector3d centre = points * area / area.sum();
  const double outward =
      ((points.colwise() - centre).cwiseProduct(normals)).colwise().sum().dot(area);
  if (outward < 0.0) normals = -normals;
}

/// Gives points that have no normal the estimated one, turned as their neighbours' ones look;
/// how many these are.
Eigen::Index fillGaps(const Eigen::Matrix3Xd& points,
                      const KdTree& tree,
                      int neighbours,
                      const Eigen::Matrix3Xd& estimated,
                      Eigen::Matrix3Xd& normals) {
  Eigen::Index missing = 0;
  for (Eigen::Index i = 0; i < normals.cols(); ++i) {
    if (!normals.col(i).isZero()) continue;
    ++missing;
    Eigen::Vector3d near = Eigen::Vector3d::Zero();
    for (const KdTree::Hit& hit : tree.nearestFew(points.col(i), neighbours))
      near += normals.col(hit.index);
    normals.col(i) = (near.dot(estimated.col(i)) < 0.0 ? -1.0 : 1.0) * estimated.col(i);
  }
  return missing;
}

/// The cloud's own where they agree with each other, else estimated ones; says which in
/// `prepared`.
Eigen::Matrix3Xd normalsOf(const PointCloud& cloud,
                           const KdTree& tree,
                           const Eigen::VectorXd& reach,
                           const Progress& progress,
                           PreparedCloud& prepared) {
  Eigen::Matrix3Xd normals = normalized(cloud.normals_O);
  if (normals.cols() > 0) {
    prepared.normals_given = agreementOf(cloud.points_O, normals, tree) >= kAgreeingShare;
    if (!prepared.normals_given)
      prepared.notes.emplace_back("the file's normals do not agree with each other: estimated");
  }
  if (prepared.normals_given && !(normals.colwise().squaredNorm().minCoeff() < 0.5))
    return normals;
  // Fewer neighbours where there are few points, lest a paraboloid spans half the object.
  const int fitted =
      std::clamp(static_cast<int>(cloud.points_O.cols()) / 10, 8, kFittedNeighbours);
  Eigen::Matrix3Xd estimated = estimateNormals(cloud.points_O, fitted, progress);
  if (!prepared.normals_given) {
    turnOutward(cloud.points_O, reach, estimated);
    return estimated;
  }
  const Eigen::Index missing = fillGaps(cloud.points_O, tree, fitted, estimated, normals);
  prepared.notes.push_back(fmt::format("estimated {} normals that the file lacks", missing));
  return normals;
}

}  // namespace

std::vector<Eigen::Index> evenSelection(const Eigen::Matrix3Xd& points,
                                        int most,
                                        const Progress& progress) {
  std::vector<Eigen::Index> kept(static_cast<std::size_t>(points.cols()));
  std::iota(kept.begin(), kept.end(), Eigen::Index{0});
  if (points.cols() <= most) return kept;
  const double diagonal = (points.rowwise().maxCoeff() - points.rowwise().minCoeff()).norm();
  // Cells that a surface meets become fewer with their size squared.
  for (double size = diagonal / 1000.0;;
       size *= 1.05 * std::sqrt(static_cast<double>(kept.size()) / most)) {
    progress.checkpoint();
    kept = firstOfCells(points, size);
    if (std::ssize(kept) <= most) return kept;
  }
}

PreparedCloud prepare(const PointCloud& given, int most_points, const Progress& progress) {
  HANDGRAFT_REQUIRE(most_points >= kFewestPoints);
  HANDGRAFT_REQUIRE(given.normals_O.cols() == 0 ||
                    given.normals_O.cols() == given.points_O.cols());
  progress.report("cleaning the points", 0.0);
  requireEnough(given.points_O.cols(), "points");
  requireFinite(given);
  PreparedCloud prepared;
  PointCloud cloud = given;
  mergeEqual(cloud, prepared.notes);
  thin(cloud, most_points, progress, prepared.notes);
  requireEnough(cloud.points_O.cols(), "distinct points");
  progress.checkpoint();

  KdTree tree(cloud.points_O);
  Spread spread = spreadOf(cloud.points_O, tree, progress);
  if (keepLargestPiece(cloud, spread.gap, prepared.notes)) {
    requireEnough(cloud.points_O.cols(), "points in its largest piece");
    tree = KdTree(cloud.points_O);
    spread = spreadOf(cloud.points_O, tree, progress);
  }
  requireSpace(cloud.points_O);
  prepared.spacing_m = spread.spacing;
  prepared.gap_m = spread.gap;
  prepared.unevenness = spread.unevenness;

  progress.report("estimating normals", 0.1);
  Eigen::Matrix3Xd normals = normalsOf(cloud, tree, spread.reach, progress, prepared);
  prepared.roughness_m = roughnessOf(cloud.points_O, normals, tree);
  prepared.points_O = std::move(cloud.points_O);
  prepared.normals_O = std::move(normals);
  return prepared;
}

}  // namespace handgraft::cloud
