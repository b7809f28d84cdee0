#include "core/geometry/reference_axis.h"

#include <cmath>
#include <numbers>

#include "core/geometry/log_map_source.h"

namespace handgraft::geometry {
namespace {

constexpr double kOneTurn = 1e-9;  // rad; fans that turn alike do so to rounding

/// The neighbour to look at: at a vertex the one most square to the normal, elsewhere the
/// farthest. On an edge its ends alone lie in the tangent plane.
const SourceNeighbour* bestNeighbour(const TriangleMesh& mesh, const SourceLayout& layout) {
  const bool is_on_edge = layout.vertex < 0 && layout.faces.size() == 2;
  const std::size_t count = is_on_edge ? 2 : layout.neighbours.size();
  const SourceNeighbour* best = nullptr;
  double best_score = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    const SourceNeighbour& neighbour = layout.neighbours[i];
    if (!(neighbour.r > 0.0)) continue;
    const Eigen::Vector3d edge = mesh.vertex(neighbour.vertex) - layout.origin;
    const double score =
        layout.vertex < 0
            ? neighbour.r
            : edge.stableNormalized().cross(mesh.vertexNormals().col(layout.vertex)).norm();
    if (score > best_score) {
      best_score = score;
      best = &neighbour;
    }
  }
  return best;
}

}  // namespace

ReferenceAxis referenceAxis(const TriangleMesh& mesh,
                            const SurfacePoint& source,
                            const Eigen::Vector3d& wanted) {
  ReferenceAxis none = {wanted, 0.0};
  const SourceLayout layout = layOutSource(mesh, source, wanted);
  const SourceNeighbour* neighbour = bestNeighbour(mesh, layout);
  if (neighbour == nullptr) return none;

  ReferenceAxis axis;
  axis.direction = (mesh.vertex(neighbour->vertex) - layout.origin).stableNormalized();
  const SourceLayout reference = layOutSource(mesh, source, axis.direction);
  // phi against the reference less phi against the wanted direction, the same for all.
  const auto turn_of = [&](std::size_t i) {
    const Eigen::Vector2d& a = layout.neighbours[i].direction_T;
    const Eigen::Vector2d& b = reference.neighbours[i].direction_T;
    return std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b));
  };
  axis.angle = turn_of(static_cast<std::size_t>(neighbour - layout.neighbours.data()));
  for (std::size_t i = 0; i < layout.neighbours.size(); ++i) {
    if (!(layout.neighbours[i].r > 0.0)) continue;
    if (std::abs(std::remainder(turn_of(i) - axis.angle, 2.0 * std::numbers::pi)) > kOneTurn)
      return none;
  }
  return axis;
}

}  // namespace handgraft::geometry
