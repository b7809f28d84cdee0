#include "core/geometry/distance_grid.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "core/base/error.h"
#include "core/geometry/wide.h"

namespace handgraft::geometry {

namespace {

// Nodes: every kCoarse-th is exact, and all within kBand spacings of the surface.
constexpr int kCoarse = 3;
constexpr double kBand = 2.0;

// Spacings between the mesh's box and the grid's border.
constexpr double kMargin = 3.0;

/// Four nodes side by side. A spline takes three of them: the last one's weight is 0.
using FloatLanes = float __attribute__((vector_size(16)));

/// Of a quadratic B-spline at t in [-1/2, 1/2] from its middle node.
struct Weights {
  [[gnu::always_inline]] explicit Weights(double t)
      : value{0.5 * (0.5 - t) * (0.5 - t), 0.75 - t * t, 0.5 * (0.5 + t) * (0.5 + t), 0.0},
        slope{t - 0.5, -2.0 * t, t + 0.5, 0.0} {}

  Lanes value;
  Lanes slope;
};

/// The 27 nodes about a place, and how far on the next row and the next plane are.
struct Stencil {
  const float* first;
  std::ptrdiff_t row;
  std::ptrdiff_t plane;
};

[[gnu::always_inline]] inline double sumOf(const Lanes& lanes) {
  return lanes[0] + lanes[1] + lanes[2];
}

[[gnu::always_inline]] inline void readRow(const Stencil& stencil, int j, int k, Lanes& row) {
  FloatLanes nodes;
  std::memcpy(&nodes, stencil.first + k * stencil.plane + j * stencil.row, sizeof nodes);
  row = __builtin_convertvector(nodes, Lanes);
}

[[gnu::always_inline]] inline double valueIn(const Stencil& stencil,
                                             const Weights& x,
                                             const Weights& y,
                                             const Weights& z) {
  Lanes row;
  Lanes sum{};
  for (int k = 0; k < 3; ++k) {
    for (int j = 0; j < 3; ++j) {
      readRow(stencil, j, k, row);
      sum += z.value[k] * y.value[j] * row;
    }
  }
  return sumOf(x.value * sum);
}

/// The gradient a spacing, too.
[[gnu::always_inline]] inline double valueIn(const Stencil& stencil,
                                             const Weights& x,
                                             const Weights& y,
                                             const Weights& z,
                                             Eigen::Vector3d& gradient) {
  Lanes row;
  Lanes sum{};
  Lanes along_y{};
  Lanes along_z{};
  for (int k = 0; k < 3; ++k) {
    for (int j = 0; j < 3; ++j) {
      readRow(stencil, j, k, row);
      sum += z.value[k] * y.value[j] * row;
      along_y += z.value[k] * y.slope[j] * row;
      along_z += z.slope[k] * y.value[j] * row;
    }
  }
  gradient << sumOf(x.slope * sum), sumOf(x.value * along_y), sumOf(x.value * along_z);
  return sumOf(x.value * sum);
}

}  // namespace

DistanceGrid::DistanceGrid(std::shared_ptr<const SignedDistance> exact,
                           const DistanceGridOptions& options,
                           const Progress& progress,
                           std::vector<float> values)
    : exact_(std::move(exact)), values_(std::move(values)) {
  HANDGRAFT_REQUIRE(exact_ != nullptr);
  if (!(options.least_spacing_m > 0.0)) {
    rejectInput("spacing of a distance grid: {} m must be above 0", options.least_spacing_m);
  }
  if (options.most_nodes < 1000 || options.most_nodes > 16000000) {
    rejectInput("nodes of a distance grid: {} must lie in 1000 to 16000000",
                options.most_nodes);
  }
  const Eigen::Matrix3Xd& vertices = exact_->surface().vertices();
  const Eigen::Vector3d low = vertices.rowwise().minCoeff();
  const Eigen::Vector3d size = vertices.rowwise().maxCoeff() - low;
  const auto counts_at = [&](double spacing) {
    Eigen::Vector3i counts;
    for (int a = 0; a < 3; ++a) {
      const int cells = static_cast<int>(std::ceil(size[a] / spacing + 2.0 * kMargin));
      counts[a] = kCoarse * ((cells + kCoarse - 1) / kCoarse) + 1;
    }
    return counts;
  };
  // No grid is larger than its longest side lets it be; coarser by steps of 2 %.
  spacing_ = std::max(options.least_spacing_m, size.maxCoeff() / options.most_nodes);
  while (counts_at(spacing_).cast<double>().prod() > options.most_nodes)
    spacing_ *= 1.02;
  counts_ = counts_at(spacing_);
  per_spacing_ = 1.0 / spacing_;
  origin_ = low + 0.5 * (size - spacing_ * (counts_.array() - 1).matrix().cast<double>());
  // Half a spacing inside the outermost nodes; a little more, for rounding.
  const Eigen::Vector3d edge = Eigen::Vector3d::Constant(0.501 * spacing_);
  box_ = Eigen::AlignedBox3d(Eigen::Vector3d(origin_ + edge),
                             Eigen::Vector3d(place((counts_.array() - 1).matrix()) - edge));
  const bool is_known = values_.size() == valueCount() &&
                        std::all_of(values_.begin(), values_.end(), [](float value) {
                          return std::isfinite(value);
                        });
  if (!is_known) fill(progress);
}

std::size_t DistanceGrid::valueCount() const {
  // Rows are read four nodes at a time: one more behind the last.
  return static_cast<std::size_t>(counts_.prod()) + 1;
}

Eigen::Vector3d DistanceGrid::place(const Eigen::Vector3i& node) const {
  return origin_ + spacing_ * node.cast<double>();
}

double DistanceGrid::signOf(const Eigen::Vector3i& node,
                            double distance,
                            int step,
                            const std::vector<float>& known) const {
  // No way shorter than a distance meets the surface, where alone the sign changes.
  for (int axis = 0; axis < 3; ++axis) {
    if (node[axis] < step) continue;
    Eigen::Vector3i before = node;
    before[axis] -= step;
    const double other = known[indexOf(before)];
    if (std::max(distance, std::abs(other)) > 1.001 * step * spacing_)
      return std::signbit(other) ? -1.0 : 1.0;
  }
  return exact_->contains(place(node)) ? -1.0 : 1.0;
}

void DistanceGrid::fillCoarse(const Progress& progress) {
  for (int z = 0; z < counts_[2]; z += kCoarse) {
    progress.checkpoint();
    for (int y = 0; y < counts_[1]; y += kCoarse) {
      for (int x = 0; x < counts_[0]; x += kCoarse) {
        const Eigen::Vector3i node(x, y, z);
        const double distance = exact_->distance(place(node));
        values_[indexOf(node)] =
            static_cast<float>(signOf(node, distance, kCoarse, values_) * distance);
      }
    }
  }
}

/// Far from the surface the coarse nodes about a node tell its value, near it the surface does.
double DistanceGrid::fineValueAt(const Eigen::Vector3i& node) const {
  const Eigen::Vector3i last_cell = ((counts_.array() - 1) / kCoarse - 1).matrix();
  const Eigen::Vector3i cell = (node / kCoarse).cwiseMin(last_cell);
  const Eigen::Vector3i corner = kCoarse * cell;
  const Eigen::Vector3d t = (node - corner).cast<double>() / kCoarse;
  double bound = 0.0;  // of the distance, from below
  double blended = 0.0;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3i side(i & 1, (i >> 1) & 1, i >> 2);
    const double value = values_[indexOf(corner + kCoarse * side)];
    const double way = spacing_ * (node - corner - kCoarse * side).cast<double>().norm();
    bound = std::max(bound, std::abs(value) - way);
    double weight = 1.0;
    for (int a = 0; a < 3; ++a)
      weight *= side[a] == 1 ? t[a] : 1.0 - t[a];
    blended += weight * value;
  }
  if (bound > kBand * spacing_) return blended;
  const double distance = exact_->distance(place(node));
  return signOf(node, distance, 1, values_) * distance;
}

void DistanceGrid::fill(const Progress& progress) {
  values_.assign(valueCount(), 0.0F);
  fillCoarse(progress);
  for (int z = 0; z < counts_[2]; ++z) {
    progress.checkpoint();
    for (int y = 0; y < counts_[1]; ++y) {
      for (int x = 0; x < counts_[0]; ++x) {
        const Eigen::Vector3i node(x, y, z);
        if (x % kCoarse == 0 && y % kCoarse == 0 && z % kCoarse == 0) continue;
        values_[indexOf(node)] = static_cast<float>(fineValueAt(node));
      }
    }
  }
}

template <class Take>
[[gnu::always_inline]] inline double DistanceGrid::look(const Eigen::Vector3d& p,
                                                        const Take& take) const {
  const double outside = box_.squaredExteriorDistance(p);
  if (outside > 0.0) return std::sqrt(outside) + (kMargin - 0.6) * spacing_;
  const Eigen::Vector3d u = (p - origin_) * per_spacing_;
  const Eigen::Vector3i middle = (u.array() + 0.5).cast<int>();
  const Stencil stencil{values_.data() + indexOf((middle.array() - 1).matrix()), counts_[0],
                        static_cast<std::ptrdiff_t>(counts_[0]) * counts_[1]};
  return take(stencil, Weights(u[0] - middle[0]), Weights(u[1] - middle[1]),
              Weights(u[2] - middle[2]));
}

HANDGRAFT_WIDE double DistanceGrid::at(const Eigen::Vector3d& p) const {
  return look(
      p, [](const auto&... query) __attribute__((always_inline)) { return valueIn(query...); });
}

HANDGRAFT_WIDE double DistanceGrid::at(const Eigen::Vector3d& p,
                                       Eigen::Vector3d& gradient) const {
  gradient.setZero();
  const double value = look(
      p, [&gradient](const auto&... query)
             __attribute__((always_inline)) { return valueIn(query..., gradient); });
  gradient *= per_spacing_;
  return value;
}

HANDGRAFT_WIDE double DistanceGrid::atLeast(const Eigen::Vector3d& p) const {
  if (!box_.contains(p)) return 0.0;
  const Eigen::Vector3d u = (p - origin_) * per_spacing_;
  const Eigen::Vector3i middle = (u.array() + 0.5).cast<int>();
  const Eigen::Vector3d t = u - middle.cast<double>();
  const float* const first = values_.data() + indexOf((middle.array() - 1).matrix());
  const std::ptrdiff_t next_row = counts_[0];
  const std::ptrdiff_t plane = next_row * counts_[1];
  // Nodes beyond the band are blended: all that is sure of them is that they lie beyond it, and
  // of those inside not even how far in.
  const double most = kBand * spacing_;
  double bound = -std::numeric_limits<double>::infinity();
  for (int k = -1; k <= 1; ++k) {
    for (int j = -1; j <= 1; ++j) {
      const float* const row = first + (k + 1) * plane + (j + 1) * next_row;
      const double across = (t[2] - k) * (t[2] - k) + (t[1] - j) * (t[1] - j);
      for (int i = -1; i <= 1; ++i) {
        const double value = row[i + 1];
        const double way = spacing_ * std::sqrt(across + (t[0] - i) * (t[0] - i));
        if (value > 0.0) bound = std::max(bound, std::min(value, most) - way);
      }
    }
  }
  return bound;
}

std::vector<DistanceGrid::Cell> DistanceGrid::solidCells() const {
  std::vector<Cell> cells;
  for (int z = 0; z < counts_[2]; ++z) {
    for (int y = 0; y < counts_[1]; ++y) {
      for (int x = 0; x < counts_[0]; ++x) {
        const Eigen::Vector3i node(x, y, z);
        const double share = std::clamp(0.5 - values_[indexOf(node)] * per_spacing_, 0.0, 1.0);
        if (share > 0.0) cells.push_back({place(node), share});
      }
    }
  }
  return cells;
}

}  // namespace handgraft::geometry
