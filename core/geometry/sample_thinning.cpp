#include "core/geometry/sample_thinning.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "core/base/error.h"

namespace handgraft::geometry {

namespace {

using Cell = Eigen::Vector3i;

Cell cellOf(const Eigen::Vector3d& p, double spacing) {
  return (p / spacing).array().floor().cast<int>();
}

/// The points of each cell, as chains: a hash table with open addresses.
class Cells {
 public:
  explicit Cells(Eigen::Index points)
      : slots_(std::bit_ceil(2 * static_cast<std::size_t>(points) + 2)),
        next_(static_cast<std::size_t>(points), -1) {}

  void add(const Cell& cell, int point) {
    Slot& slot = slots_[find(cell)];
    next_[static_cast<std::size_t>(point)] = slot.first;
    slot = {cell, point};
  }

  /// -1: none.
  [[nodiscard]] int first(const Cell& cell) const { return slots_[find(cell)].first; }

  [[nodiscard]] int next(int point) const { return next_[static_cast<std::size_t>(point)]; }

 private:
  struct Slot {
    Cell cell = Cell::Zero();
    int first = -1;
  };

  [[nodiscard]] std::size_t find(const Cell& cell) const {
    // Teschner et al. 2003, "Optimized spatial hashing".
    const auto hash = (static_cast<std::uint32_t>(cell[0]) * 73856093U) ^
                      (static_cast<std::uint32_t>(cell[1]) * 19349663U) ^
                      (static_cast<std::uint32_t>(cell[2]) * 83492791U);
    std::size_t index = hash & (slots_.size() - 1);
    while (slots_[index].first >= 0 && slots_[index].cell != cell)
      index = (index + 1) & (slots_.size() - 1);
    return index;
  }

  std::vector<Slot> slots_;
  std::vector<int> next_;
};

}  // namespace

Thinned thinOut(const Eigen::Matrix3Xd& points,
                const std::vector<int>& groups,
                double spacing) {
  HANDGRAFT_REQUIRE(spacing > 0.0 && points.cols() == std::ssize(groups));
  Thinned thinned;
  Cells cells(points.cols());  // of entries of `kept`
  // The nearest kept point of the group, if any is within a cell or so.
  const auto nearest_to = [&](Eigen::Index i, double& distance) {
    int best = -1;
    distance = std::numeric_limits<double>::infinity();
    const Cell middle = cellOf(points.col(i), spacing);
    for (int step = 0; step < 27; ++step) {
      const Cell cell = middle + Cell(step / 9 - 1, step / 3 % 3 - 1, step % 3 - 1);
      for (int k = cells.first(cell); k >= 0; k = cells.next(k)) {
        const int other = thinned.kept[static_cast<std::size_t>(k)];
        if (groups[static_cast<std::size_t>(other)] != groups[static_cast<std::size_t>(i)])
          continue;
        const double way = (points.col(i) - points.col(other)).norm();
        // Of two as near, the one kept first.
        if (way > distance || (way == distance && k > best)) continue;
        distance = way;
        best = k;
      }
    }
    return best;
  };

  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    double distance = 0.0;
    nearest_to(i, distance);
    if (distance < spacing) continue;
    cells.add(cellOf(points.col(i), spacing), static_cast<int>(thinned.kept.size()));
    thinned.kept.push_back(static_cast<int>(i));
  }
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    double distance = 0.0;
    thinned.nearest.push_back(nearest_to(i, distance));
  }
  return thinned;
}

}  // namespace handgraft::geometry
