#include "core/hand/tunnel_plugs.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <unordered_map>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/hand/voxel_solid.h"

namespace handgraft::hand {

namespace {

/// Memory and time end here: 4 million voxels are a hand at 1.2 mm.
constexpr std::size_t kMostVoxels = 4'000'000;
constexpr int kSmoothingRounds = 10;
/// Voxels that the area of triangles covers; a hand's are some hundred thousand.
constexpr double kMostCovered = 2e7;
/// Of the radius that wraps bridge. A tunnel too many costs nothing, one too few a second wrap:
/// with 0.8 one hand of ten lost a second, with this two of ten still have tiny ones.
constexpr double kRollingShare = 0.6;
/// Below this the voxels are of several pieces, and what would shut their tunnels would join
/// them, too.
constexpr double kOnePiece = 0.97;

/// Voxels of the sheets and those of the solid that hold them at the rim, as vertices.
class SheetBuilder {
 public:
  SheetBuilder(const VoxelSet& solid, const VoxelSet& shut, const VoxelGrid& grid)
      : solid_(solid), shut_(shut), grid_(grid) {}

  TunnelPlugs build() {
    for (std::size_t i = 0; i < solid_.size(); ++i)
      if (isSheet(i)) sheet_.push_back(i);
    TunnelPlugs plugs;
    plugs.count = countPieces();
    plugs.area_m2 = static_cast<double>(sheet_.size()) * grid_.step_m * grid_.step_m;
    if (sheet_.empty()) return plugs;
    span();
    smooth();
    Eigen::Matrix3Xd vertices(3, static_cast<Eigen::Index>(points_.size()));
    for (std::size_t i = 0; i < points_.size(); ++i)
      vertices.col(static_cast<Eigen::Index>(i)) = points_[i];
    Eigen::Matrix3Xi faces(3, static_cast<Eigen::Index>(faces_.size()));
    for (std::size_t i = 0; i < faces_.size(); ++i)
      faces.col(static_cast<Eigen::Index>(i)) = faces_[i];
    plugs.sheets_S = geometry::TriangleMesh(std::move(vertices), std::move(faces));
    return plugs;
  }

 private:
  [[nodiscard]] bool isSheet(std::size_t i) const { return shut_[i] != 0 && solid_[i] == 0; }

  int vertexOf(std::size_t voxel) {
    const auto [found, is_new] =
        vertex_of_.try_emplace(voxel, static_cast<int>(points_.size()));
    if (is_new) {
      points_.push_back(grid_.middle(voxel));
      is_held_.push_back(solid_[voxel] != 0);
    }
    return found->second;
  }

  using Seen = std::unordered_map<std::size_t, bool>;

  /// 26-connected pieces of the sheet voxels.
  [[nodiscard]] int countPieces() const {
    Seen is_seen;
    for (const std::size_t voxel : sheet_)
      is_seen[voxel] = false;
    int pieces = 0;
    for (const std::size_t start : sheet_) {
      if (is_seen[start]) continue;
      ++pieces;
      seePiece(start, is_seen);
    }
    return pieces;
  }

  void seePiece(std::size_t start, Seen& is_seen) const {
    is_seen[start] = true;
    std::vector<std::size_t> waiting{start};
    while (!waiting.empty()) {
      const Eigen::Vector3i c = grid_.cell(waiting.back());
      waiting.pop_back();
      for (int k = 0; k < 27; ++k) {
        const auto found = is_seen.find(
            grid_.index(c.x() + k % 3 - 1, c.y() + k / 3 % 3 - 1, c.z() + k / 9 - 1));
        if (found == is_seen.end() || found->second) continue;
        found->second = true;
        waiting.push_back(found->first);
      }
    }
  }

  /// Triangles between the middles of any three voxels of a 2 x 2 x 2 block of which one is of
  /// a sheet: more than a surface needs, but without a gap however the voxels touch.
  void span() {
    std::unordered_map<std::size_t, bool> is_done;
    for (const std::size_t voxel : sheet_) {
      const Eigen::Vector3i c = grid_.cell(voxel);
      for (int block = 0; block < 8; ++block) {
        const Eigen::Vector3i low = c - Eigen::Vector3i(block & 1, block >> 1 & 1, block >> 2);
        if (!std::exchange(is_done[grid_.index(low.x(), low.y(), low.z())], true))
          spanBlock(shutCellsOf(low));
      }
    }
  }

  /// The cells of the block whose lowest one is `low` that are of the solid or of a sheet.
  [[nodiscard]] std::vector<std::size_t> shutCellsOf(const Eigen::Vector3i& low) const {
    std::vector<std::size_t> cells;
    for (int k = 0; k < 8; ++k) {
      const std::size_t cell =
          grid_.index(low.x() + (k & 1), low.y() + (k >> 1 & 1), low.z() + (k >> 2));
      if (shut_[cell] != 0) cells.push_back(cell);
    }
    return cells;
  }

  void spanBlock(const std::vector<std::size_t>& cells) {
    for (std::size_t a = 0; a < cells.size(); ++a)
      for (std::size_t b = a + 1; b < cells.size(); ++b)
        for (std::size_t d = b + 1; d < cells.size(); ++d)
          if (isSheet(cells[a]) || isSheet(cells[b]) || isSheet(cells[d]))
            faces_.emplace_back(vertexOf(cells[a]), vertexOf(cells[b]), vertexOf(cells[d]));
  }

  /// Takes the steps of the grid out of the sheets; what lies in the solid stays.
  void smooth() {
    for (int round = 0; round < kSmoothingRounds; ++round) {
      std::vector<Eigen::Vector3d> sum(points_.size(), Eigen::Vector3d::Zero());
      std::vector<double> count(points_.size(), 0.0);
      for (const Eigen::Vector3i& face : faces_) {
        for (int c = 0; c < 3; ++c) {
          const auto at = static_cast<std::size_t>(face[c]);
          for (const int other : {face[(c + 1) % 3], face[(c + 2) % 3]}) {
            sum[at] += points_[static_cast<std::size_t>(other)];
            count[at] += 1.0;
          }
        }
      }
      for (std::size_t i = 0; i < points_.size(); ++i)
        if (!is_held_[i]) points_[i] = 0.5 * points_[i] + 0.5 * sum[i] / count[i];
    }
  }

  const VoxelSet& solid_;
  const VoxelSet& shut_;
  const VoxelGrid& grid_;
  std::vector<std::size_t> sheet_;
  std::unordered_map<std::size_t, int> vertex_of_;
  std::vector<Eigen::Vector3d> points_;
  std::vector<bool> is_held_;
  std::vector<Eigen::Vector3i> faces_;
};

}  // namespace

TunnelPlugs findTunnelPlugs(const geometry::TriangleMesh& surface_S, double step_m) {
  HANDGRAFT_REQUIRE(surface_S.isClosed());
  const VoxelGrid grid = gridAround(surface_S, step_m, kMostVoxels);
  const VoxelSet solid = voxelsInside(surface_S, grid);
  const VoxelSet shut = shrinkWrapped(solid, grid);
  return SheetBuilder(solid, shut, grid).build();
}

TunnelPlugs findTunnelPlugsOfWrap(const geometry::TriangleMesh& triangles_S,
                                  double alpha_m,
                                  double offset_m,
                                  double step_m) {
  const double radius = alpha_m + offset_m;
  const VoxelGrid grid = gridAround(triangles_S, step_m, kMostVoxels, radius);
  if (triangles_S.area() > kMostCovered * grid.step_m * grid.step_m) return {};
  const auto [solid, share] =
      largestPiece(voxelsOutOfReach(triangles_S, grid, kRollingShare * radius), grid);
  if (share < kOnePiece) return {};
  const VoxelSet shut = shrinkWrapped(solid, grid);
  return SheetBuilder(solid, shut, grid).build();
}

}  // namespace handgraft::hand
