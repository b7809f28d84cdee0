#pragma once

#include <memory>
#include <mutex>

#include "core/geometry/heat_log_map.h"
#include "core/geometry/log_map.h"

namespace handgraft::geometry {

/// Log maps of one mesh by any method: what the heat methods factor is made once, when first
/// asked for, and kept. Const, safe from several threads.
class LogMapper {
 public:
  /// Shares the mesh.
  explicit LogMapper(std::shared_ptr<const TriangleMesh> mesh);
  /// Borrows a mesh that outlives this and all that is made with it.
  static std::shared_ptr<const LogMapper> borrowing(const TriangleMesh& mesh);

  [[nodiscard]] const TriangleMesh& mesh() const { return *mesh_; }

  /// As `computeLogMap`, with the same errors and the same result.
  /// Cost: as there, but for the factorisation, which the first query alone pays.
  [[nodiscard]] LogMap map(const SurfacePoint& source,
                           const Eigen::Vector3d& direction,
                           double radius,
                           LogMapMethod method) const;

 private:
  [[nodiscard]] const HeatLogMap& heat() const;

  std::shared_ptr<const TriangleMesh> mesh_;
  mutable std::once_flag heat_once_;
  mutable std::unique_ptr<const HeatLogMap> heat_;
};

}  // namespace handgraft::geometry
