#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "core/geometry/triangle_mesh.h"

namespace handgraft::hand {

/// A box of cubic voxels in frame S; a voxel is its middle.
struct VoxelGrid {
  Eigen::Vector3d origin_S = Eigen::Vector3d::Zero();  ///< middle of voxel (0, 0, 0)
  Eigen::Vector3i size = Eigen::Vector3i::Zero();
  double step_m = 0.0;

  [[nodiscard]] std::size_t count() const {
    return static_cast<std::size_t>(size.x()) * static_cast<std::size_t>(size.y()) *
           static_cast<std::size_t>(size.z());
  }

  [[nodiscard]] std::size_t index(int x, int y, int z) const {
    return (static_cast<std::size_t>(z) * static_cast<std::size_t>(size.y()) +
            static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(size.x()) +
           static_cast<std::size_t>(x);
  }

  [[nodiscard]] Eigen::Vector3i cell(std::size_t index) const {
    const auto nx = static_cast<std::size_t>(size.x());
    const auto ny = static_cast<std::size_t>(size.y());
    return {static_cast<int>(index % nx), static_cast<int>(index / nx % ny),
            static_cast<int>(index / nx / ny)};
  }

  [[nodiscard]] Eigen::Vector3d middle(std::size_t index) const {
    return origin_S + step_m * cell(index).cast<double>();
  }
};

/// One byte a voxel, nonzero inside.
using VoxelSet = std::vector<std::uint8_t>;

/// A grid around the mesh with two free voxels on every side and at least `margin_m`, of at
/// most `max_voxels`: its step is `step_m` or, where that would be too many, larger.
VoxelGrid gridAround(const geometry::TriangleMesh& mesh_S,
                     double step_m,
                     std::size_t max_voxels,
                     double margin_m = 0.0);

/// The voxels inside a closed, oriented surface that does not cross itself.
/// Cost: linear in the voxels and in the columns that triangles cover.
VoxelSet voxelsInside(const geometry::TriangleMesh& mesh_S, const VoxelGrid& grid);

/// What a ball that rolls around the triangles, which may be open, crossing and turned, cannot
/// reach: to about a voxel. The grid must leave the ball room around them.
/// Cost: linear in the voxels and in the triangles' area.
VoxelSet voxelsOutOfReach(const geometry::TriangleMesh& triangles_S,
                          const VoxelGrid& grid,
                          double ball_radius_m);

/// The largest of the pieces that hang together by 26 neighbours, and its share of the voxels;
/// 0 where there are none.
std::pair<VoxelSet, double> largestPiece(const VoxelSet& solid, const VoxelGrid& grid);

/// The smallest ball-like voxel set that holds `solid`: shrinks the whole grid voxel by voxel,
/// the farthest from the solid first, and takes away only what changes no topology. What is
/// left besides the solid are sheets of one voxel that shut its tunnels at their narrowest
/// place, and its cavities.
///
/// 26-connected solid, 6-connected outside. The grid's outermost layer must be free.
/// Deterministic. Cost: some 0.3 us a voxel. Source: simple points as of Bertrand & Malandain
/// 1994, "A new characterization of three-dimensional simple points".
VoxelSet shrinkWrapped(const VoxelSet& solid, const VoxelGrid& grid);

}  // namespace handgraft::hand
