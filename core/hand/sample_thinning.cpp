#include "core/hand/sample_thinning.h"

#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "core/base/error.h"

namespace handgraft::hand {

namespace {

using Cell = std::array<int, 3>;

Cell cellOf(const Eigen::Vector3d& p, double spacing) {
  Cell cell;
  for (int a = 0; a < 3; ++a)
    cell[static_cast<std::size_t>(a)] = static_cast<int>(std::floor(p[a] / spacing));
  return cell;
}

}  // namespace

Thinned thinOut(const Eigen::Matrix3Xd& points,
                const std::vector<int>& groups,
                double spacing) {
  HANDGRAFT_REQUIRE(spacing > 0.0 && points.cols() == std::ssize(groups));
  Thinned thinned;
  std::map<Cell, std::vector<int>> grid;  // entries of `kept`
  // The nearest kept point of the group, if any is within a cell or so.
  const auto nearestTo = [&](Eigen::Index i, double& distance) {
    int best = -1;
    distance = std::numeric_limits<double>::infinity();
    const Cell middle = cellOf(points.col(i), spacing);
    for (int x = -1; x <= 1; ++x) {
      for (int y = -1; y <= 1; ++y) {
        for (int z = -1; z <= 1; ++z) {
          const auto cell = grid.find({middle[0] + x, middle[1] + y, middle[2] + z});
          if (cell == grid.end()) continue;
          for (const int k : cell->second) {
            const int other = thinned.kept[static_cast<std::size_t>(k)];
            if (groups[static_cast<std::size_t>(other)] != groups[static_cast<std::size_t>(i)])
              continue;
            const double way = (points.col(i) - points.col(other)).norm();
            if (way >= distance) continue;
            distance = way;
            best = k;
          }
        }
      }
    }
    return best;
  };

  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    double distance = 0.0;
    nearestTo(i, distance);
    if (distance < spacing) continue;
    grid[cellOf(points.col(i), spacing)].push_back(static_cast<int>(thinned.kept.size()));
    thinned.kept.push_back(static_cast<int>(i));
  }
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    double distance = 0.0;
    thinned.nearest.push_back(nearestTo(i, distance));
  }
  return thinned;
}

}  // namespace handgraft::hand
