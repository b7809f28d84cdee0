#include "core/hand/voxel_solid.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>

#include "core/base/error.h"

namespace handgraft::hand {

namespace {

constexpr int kFreeLayers = 2;
/// A shift of the grid against the mesh, so that no column meets a vertex of a mesh with round
/// coordinates.
const Eigen::Vector3d grid_shift(0.2718, 0.3141, 0.1414);

/// Twice the signed area of (a, b, p), the same number but for its sign when a and b change
/// places: two triangles agree exactly on which side of their common edge a column lies.
double side(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& p) {
  const bool swapped = b.x() < a.x() || (b.x() == a.x() && b.y() < a.y());
  const Eigen::Vector2d& u = swapped ? b : a;
  const Eigen::Vector2d& v = swapped ? a : b;
  const double area = (v.x() - u.x()) * (p.y() - u.y()) - (v.y() - u.y()) * (p.x() - u.x());
  return swapped ? -area : area;
}

// === Distance to the solid

/// Squared distances along one line, in place (Felzenszwalb & Huttenlocher 2012).
void distanceAlongLine(std::vector<float>& line,
                       std::vector<float>& out,
                       std::vector<int>& hull,
                       std::vector<float>& breaks) {
  const int n = static_cast<int>(line.size());
  constexpr float kFar = std::numeric_limits<float>::infinity();
  int top = -1;
  for (int q = 0; q < n; ++q) {
    if (line[static_cast<std::size_t>(q)] == kFar) continue;
    float from = -kFar;
    while (top >= 0) {
      const int v = hull[static_cast<std::size_t>(top)];
      from = (line[static_cast<std::size_t>(q)] + static_cast<float>(q * q) -
              line[static_cast<std::size_t>(v)] - static_cast<float>(v * v)) /
             static_cast<float>(2 * (q - v));
      if (from > breaks[static_cast<std::size_t>(top)]) break;
      --top;
    }
    if (top < 0) from = -kFar;
    ++top;
    hull[static_cast<std::size_t>(top)] = q;
    breaks[static_cast<std::size_t>(top)] = from;
  }
  if (top < 0) return;
  int k = 0;
  for (int q = 0; q < n; ++q) {
    while (k < top && breaks[static_cast<std::size_t>(k) + 1] < static_cast<float>(q))
      ++k;
    const int v = hull[static_cast<std::size_t>(k)];
    out[static_cast<std::size_t>(q)] =
        static_cast<float>((q - v) * (q - v)) + line[static_cast<std::size_t>(v)];
  }
  line.swap(out);
}

/// Squared distance of every voxel to the nearest one of the solid, in voxels.
std::vector<float> squaredDistances(const VoxelSet& solid, const VoxelGrid& grid) {
  std::vector<float> field(grid.count());
  for (std::size_t i = 0; i < field.size(); ++i)
    field[i] = solid[i] != 0 ? 0.0F : std::numeric_limits<float>::infinity();
  const std::array<std::size_t, 3> strides{
      1, static_cast<std::size_t>(grid.size.x()),
      static_cast<std::size_t>(grid.size.x()) * static_cast<std::size_t>(grid.size.y())};
  for (int axis = 0; axis < 3; ++axis) {
    const auto n = static_cast<std::size_t>(grid.size[axis]);
    const std::size_t stride = strides[static_cast<std::size_t>(axis)];
    std::vector<float> line(n);
    std::vector<float> out(n);
    std::vector<int> hull(n);
    std::vector<float> breaks(n);
    for (std::size_t start = 0; start < field.size(); ++start) {
      if (start / stride % n != 0) continue;
      for (std::size_t i = 0; i < n; ++i)
        line[i] = field[start + i * stride];
      distanceAlongLine(line, out, hull, breaks);
      for (std::size_t i = 0; i < n; ++i)
        field[start + i * stride] = line[i];
    }
  }
  return field;
}

// === Simple points

/// Cells of a 3 x 3 x 3 neighbourhood are bits x + 3 y + 9 z; the middle one is bit 13.
constexpr int kMiddle = 13;

struct Neighbourhoods {
  std::array<std::uint32_t, 27> all{};    ///< 26-neighbours of each cell within the cube
  std::array<std::uint32_t, 27> faces{};  ///< 6-neighbours
  std::uint32_t without_corners = 0;      ///< the 18-neighbourhood of the middle
  std::uint32_t middle_faces = 0;

  Neighbourhoods() {
    for (int a = 0; a < 27; ++a) {
      for (int b = 0; b < 27; ++b) {
        const int dx = std::abs(a % 3 - b % 3);
        const int dy = std::abs(a / 3 % 3 - b / 3 % 3);
        const int dz = std::abs(a / 9 - b / 9);
        if (a == b || b == kMiddle || std::max({dx, dy, dz}) > 1) continue;
        all[static_cast<std::size_t>(a)] |= 1U << b;
        if (dx + dy + dz == 1) faces[static_cast<std::size_t>(a)] |= 1U << b;
        if (a == kMiddle && dx + dy + dz < 3) without_corners |= 1U << b;
      }
    }
    middle_faces = faces[kMiddle];
  }
};

/// The part of `set` that is connected to `seed` by `neighbours`.
std::uint32_t flood(std::uint32_t set,
                    std::uint32_t seed,
                    const std::array<std::uint32_t, 27>& neighbours) {
  std::uint32_t reached = seed;
  std::uint32_t front = seed;
  while (front != 0) {
    const auto cell = static_cast<std::size_t>(std::countr_zero(front));
    front &= front - 1;
    const std::uint32_t fresh = neighbours[cell] & set & ~reached;
    reached |= fresh;
    front |= fresh;
  }
  return reached;
}

/// Whether the middle may leave a solid whose other cells are `solid`: one 26-component of the
/// solid around it, and one 6-component of the outside that touches it by a face.
bool isSimple(std::uint32_t solid) {
  static const Neighbourhoods all_cells;
  solid &= ~(1U << kMiddle);
  if (solid == 0) return false;
  const std::uint32_t outside = ~solid & all_cells.without_corners;
  const std::uint32_t touching = outside & all_cells.middle_faces;
  if (touching == 0) return false;
  if (flood(solid, solid & (~solid + 1), all_cells.all) != solid) return false;
  return (touching & ~flood(outside, touching & (~touching + 1), all_cells.faces)) == 0;
}

// === Triangles in voxels

using Corners = std::array<Eigen::Vector3d, 3>;

/// A face's corners, in voxels from the first one.
Corners cornersIn(const VoxelGrid& grid, const geometry::TriangleMesh& mesh_S, int f) {
  Corners p;
  for (int c = 0; c < 3; ++c)
    p[static_cast<std::size_t>(c)] =
        (mesh_S.vertex(mesh_S.face(f)[c]) - grid.origin_S) / grid.step_m;
  return p;
}

/// Where the column along z at `at` passes through a triangle, if it does.
std::optional<float> crossingOf(const Corners& p, const Eigen::Vector2d& at) {
  const double a = side(p[1].head<2>(), p[2].head<2>(), at);
  const double b = side(p[2].head<2>(), p[0].head<2>(), at);
  const double c = side(p[0].head<2>(), p[1].head<2>(), at);
  if (!((a > 0 && b > 0 && c > 0) || (a < 0 && b < 0 && c < 0))) return std::nullopt;
  const double z = (a * p[0].z() + b * p[1].z() + c * p[2].z()) / (a + b + c);
  return static_cast<float>(z);
}

/// Where each column along z enters and leaves, in no order; columns row by row.
std::vector<std::vector<float>> crossingsOf(const geometry::TriangleMesh& mesh_S,
                                            const VoxelGrid& grid) {
  const auto nx = static_cast<std::size_t>(grid.size.x());
  std::vector<std::vector<float>> crossings(nx * static_cast<std::size_t>(grid.size.y()));
  for (int f = 0; f < mesh_S.faceCount(); ++f) {
    const Corners p = cornersIn(grid, mesh_S, f);
    const Eigen::Vector2d low =
        p[0].head<2>().cwiseMin(p[1].head<2>()).cwiseMin(p[2].head<2>());
    const Eigen::Vector2d high =
        p[0].head<2>().cwiseMax(p[1].head<2>()).cwiseMax(p[2].head<2>());
    for (int y = static_cast<int>(std::ceil(low.y())); y <= high.y(); ++y) {
      for (int x = static_cast<int>(std::ceil(low.x())); x <= high.x(); ++x) {
        const std::optional<float> z = crossingOf(p, Eigen::Vector2d(x, y));
        if (!z) continue;
        crossings[static_cast<std::size_t>(y) * nx + static_cast<std::size_t>(x)].push_back(*z);
      }
    }
  }
  return crossings;
}

/// Marks the voxels on a triangle, by samples half a voxel apart.
void markTouched(const Corners& p, const VoxelGrid& grid, VoxelSet& touched) {
  // From the corner where the shortest side begins: a sliver is then walked along once.
  std::size_t first = 0;
  const auto length = [&](std::size_t c) {
    return (p[(c + 1) % 3] - p[c % 3]).norm();
  };
  for (std::size_t c = 1; c < 3; ++c)
    if (length(c) < length(first)) first = c;
  const Eigen::Vector3d& a = p[first];
  const Eigen::Vector3d ab = p[(first + 1) % 3] - a;
  const Eigen::Vector3d ac = p[(first + 2) % 3] - a;
  const double n_b = std::max(1.0, std::ceil(2.0 * ab.norm()));
  const double n_c = std::max(1.0, std::ceil(2.0 * ac.norm()));
  for (int b = 0; b <= n_b; ++b) {
    for (int c = 0; c <= n_c * (1.0 - b / n_b) + 1.0; ++c) {
      const double along = std::min(c / n_c, 1.0 - b / n_b);
      const Eigen::Vector3i cell = (a + b / n_b * ab + along * ac).array().round().cast<int>();
      touched[grid.index(cell.x(), cell.y(), cell.z())] = 1;
    }
  }
}

// === Pieces

/// The voxels that a walk from the grid's first corner, over faces, comes to without getting
/// nearer than a squared distance of `least`.
VoxelSet floodedFromOutside(const std::vector<float>& squared,
                            const VoxelGrid& grid,
                            float least) {
  HANDGRAFT_REQUIRE(squared[0] >= least);
  VoxelSet flooded(grid.count(), 0);
  std::vector<std::size_t> waiting{0};
  flooded[0] = 1;
  const auto flood_to = [&](const Eigen::Vector3i& c) {
    const std::size_t at = grid.index(c.x(), c.y(), c.z());
    if (flooded[at] != 0 || squared[at] < least) return;
    flooded[at] = 1;
    waiting.push_back(at);
  };
  while (!waiting.empty()) {
    const Eigen::Vector3i c = grid.cell(waiting.back());
    waiting.pop_back();
    for (int axis = 0; axis < 3; ++axis) {
      for (const int way : {-1, 1}) {
        Eigen::Vector3i next = c;
        next[axis] += way;
        if (next[axis] >= 0 && next[axis] < grid.size[axis]) flood_to(next);
      }
    }
  }
  return flooded;
}

/// Takes the voxels out of `set` that hang together with `start` by 26 neighbours.
std::vector<std::size_t> takePiece(std::size_t start, const VoxelGrid& grid, VoxelSet& set) {
  std::vector<std::size_t> piece{start};
  set[start] = 0;
  for (std::size_t i = 0; i < piece.size(); ++i) {
    const Eigen::Vector3i c = grid.cell(piece[i]);
    for (int k = 0; k < 27; ++k) {
      const Eigen::Vector3i next = c + Eigen::Vector3i(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
      if ((next.array() < 0).any() || (next.array() >= grid.size.array()).any()) continue;
      const std::size_t at = grid.index(next.x(), next.y(), next.z());
      if (set[at] == 0) continue;
      set[at] = 0;
      piece.push_back(at);
    }
  }
  return piece;
}

// === Shrinking

/// Voxels by their distance, farthest first, in buckets of a quarter voxel; first come, first
/// served within one, so that fronts that meet in a tunnel have come equally far.
class FarthestFirst {
 public:
  explicit FarthestFirst(std::vector<float> squared_distances)
      : squared_(std::move(squared_distances)) {
    std::size_t farthest = 0;
    for (std::size_t i = 0; i < squared_.size(); ++i) {
      HANDGRAFT_REQUIRE(std::isfinite(squared_[i]));
      farthest = std::max(farthest, bucketOf(i));
    }
    buckets_.resize(farthest + 1);
    heads_.resize(farthest + 1, 0);
  }

  void put(std::size_t voxel) {
    const std::size_t bucket = bucketOf(voxel);
    buckets_[bucket].push_back(voxel);
    current_ = std::max(current_, bucket);
  }

  /// False if none is left.
  bool take(std::size_t& voxel) {
    while (current_ > 0 && heads_[current_] == buckets_[current_].size()) {
      buckets_[current_].clear();
      heads_[current_] = 0;
      --current_;
    }
    if (heads_[current_] == buckets_[current_].size()) return false;
    voxel = buckets_[current_][heads_[current_]++];
    return true;
  }

 private:
  [[nodiscard]] std::size_t bucketOf(std::size_t voxel) const {
    return static_cast<std::size_t>(4.0F * std::sqrt(squared_[voxel]));
  }

  std::vector<float> squared_;
  std::vector<std::vector<std::size_t>> buckets_;
  std::vector<std::size_t> heads_;  ///< of each bucket: how many were taken
  std::size_t current_ = 0;
};

/// A grid that shrinks towards a solid.
class ShrinkingSet {
 public:
  ShrinkingSet(const VoxelSet& solid, const VoxelGrid& grid)
      : solid_(solid), waiting_(squaredDistances(solid, grid)), kept_(solid.size(), kKept) {
    for (int cell = 0; cell < 27; ++cell)
      offsets_[static_cast<std::size_t>(cell)] =
          (cell % 3 - 1) + static_cast<std::ptrdiff_t>(grid.size.x()) *
                               ((cell / 3 % 3 - 1) +
                                static_cast<std::ptrdiff_t>(grid.size.y()) * (cell / 9 - 1));
    // The outermost layer is gone from the start.
    const auto layer_of = [&](const Eigen::Vector3i& c) {
      return std::min(c.minCoeff(), (grid.size - c).minCoeff() - 1);
    };
    for (std::size_t i = 0; i < kept_.size(); ++i)
      if (layer_of(grid.cell(i)) == 0) kept_[i] = kGone;
    for (std::size_t i = 0; i < kept_.size(); ++i)
      if (layer_of(grid.cell(i)) == 1) wait(i);
  }

  void shrink() {
    std::size_t voxel = 0;
    while (waiting_.take(voxel)) {
      kept_[voxel] = kKept;
      if (!isSimple(keptAround(voxel))) continue;
      kept_[voxel] = kGone;
      for (std::size_t cell = 0; cell < 27; ++cell)
        wait(neighbour(voxel, cell));
    }
  }

  [[nodiscard]] VoxelSet kept() const {
    VoxelSet kept = kept_;
    for (std::uint8_t& voxel : kept)
      voxel = voxel != kGone ? 1 : 0;
    return kept;
  }

 private:
  static constexpr std::uint8_t kGone = 0;
  static constexpr std::uint8_t kKept = 1;
  static constexpr std::uint8_t kKeptAndWaiting = 2;

  [[nodiscard]] std::size_t neighbour(std::size_t voxel, std::size_t cell) const {
    return static_cast<std::size_t>(static_cast<std::ptrdiff_t>(voxel) + offsets_[cell]);
  }

  [[nodiscard]] std::uint32_t keptAround(std::size_t voxel) const {
    std::uint32_t around = 0;
    for (std::size_t cell = 0; cell < 27; ++cell)
      if (kept_[neighbour(voxel, cell)] != kGone) around |= 1U << cell;
    return around;
  }

  void wait(std::size_t voxel) {
    if (kept_[voxel] != kKept || solid_[voxel] != 0) return;
    kept_[voxel] = kKeptAndWaiting;
    waiting_.put(voxel);
  }

  const VoxelSet& solid_;
  FarthestFirst waiting_;
  VoxelSet kept_;
  std::array<std::ptrdiff_t, 27> offsets_{};
};

}  // namespace

VoxelGrid gridAround(const geometry::TriangleMesh& mesh_S,
                     double step_m,
                     std::size_t max_voxels,
                     double margin_m) {
  HANDGRAFT_REQUIRE(step_m > 0.0 && mesh_S.vertexCount() > 0);
  const Eigen::Vector3d low = mesh_S.vertices().rowwise().minCoeff();
  const Eigen::Vector3d extent = mesh_S.vertices().rowwise().maxCoeff() - low;
  VoxelGrid grid;
  int layers = kFreeLayers;
  for (grid.step_m = step_m;; grid.step_m *= 1.1) {
    layers = kFreeLayers + static_cast<int>(std::ceil(margin_m / grid.step_m));
    grid.size = (extent / grid.step_m).array().ceil().cast<int>() + 2 * layers + 1;
    if (grid.count() <= max_voxels) break;
  }
  grid.origin_S = low - grid.step_m * (Eigen::Vector3d::Constant(layers) + grid_shift);
  return grid;
}

VoxelSet voxelsInside(const geometry::TriangleMesh& mesh_S, const VoxelGrid& grid) {
  std::vector<std::vector<float>> crossings = crossingsOf(mesh_S, grid);
  const auto nx = static_cast<std::size_t>(grid.size.x());
  VoxelSet solid(grid.count(), 0);
  for (int y = 0; y < grid.size.y(); ++y) {
    for (int x = 0; x < grid.size.x(); ++x) {
      auto& column = crossings[static_cast<std::size_t>(y) * nx + static_cast<std::size_t>(x)];
      std::sort(column.begin(), column.end());
      for (std::size_t i = 0; i + 1 < column.size(); i += 2)
        for (int z = static_cast<int>(std::ceil(column[i]));
             static_cast<float>(z) <= column[i + 1]; ++z)
          solid[grid.index(x, y, z)] = 1;
    }
  }
  return solid;
}

VoxelSet voxelsOutOfReach(const geometry::TriangleMesh& triangles_S,
                          const VoxelGrid& grid,
                          double ball_radius_m) {
  VoxelSet touched(grid.count(), 0);
  for (int f = 0; f < triangles_S.faceCount(); ++f)
    markTouched(cornersIn(grid, triangles_S, f), grid, touched);
  const auto reach = static_cast<float>(ball_radius_m / grid.step_m);
  const VoxelSet middles =
      floodedFromOutside(squaredDistances(touched, grid), grid, reach * reach);
  const std::vector<float> squared = squaredDistances(middles, grid);
  VoxelSet solid(grid.count());
  for (std::size_t i = 0; i < solid.size(); ++i)
    solid[i] = squared[i] >= reach * reach ? 1 : 0;
  return solid;
}

std::pair<VoxelSet, double> largestPiece(const VoxelSet& solid, const VoxelGrid& grid) {
  VoxelSet waiting_set = solid;
  std::vector<std::size_t> largest;
  std::size_t all = 0;
  for (std::size_t start = 0; start < solid.size(); ++start) {
    if (waiting_set[start] == 0) continue;
    std::vector<std::size_t> piece = takePiece(start, grid, waiting_set);
    all += piece.size();
    if (piece.size() > largest.size()) largest = std::move(piece);
  }
  VoxelSet kept(solid.size(), 0);
  for (const std::size_t i : largest)
    kept[i] = 1;
  return {std::move(kept),
          all == 0 ? 0.0 : static_cast<double>(largest.size()) / static_cast<double>(all)};
}

VoxelSet shrinkWrapped(const VoxelSet& solid, const VoxelGrid& grid) {
  HANDGRAFT_REQUIRE(solid.size() == grid.count());
  ShrinkingSet set(solid, grid);
  set.shrink();
  return set.kept();
}

}  // namespace handgraft::hand
