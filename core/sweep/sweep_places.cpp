#include "core/sweep/sweep_places.h"

#include "core/geometry/tangent.h"

namespace handgraft::sweep {

namespace {

/// `direction_S` of a place on one mesh, as the same face of another mesh has it.
Eigen::Vector3d directionOn(const geometry::TriangleMesh& to,
                            const geometry::TriangleMesh& from,
                            const geometry::SurfacePoint& place,
                            const Eigen::Vector3d& direction) {
  const auto edges_of = [&](const geometry::TriangleMesh& mesh) {
    const Eigen::Vector3i face = mesh.face(place.face);
    Eigen::Matrix<double, 3, 2> edges;
    edges.col(0) = mesh.vertex(face[1]) - mesh.vertex(face[0]);
    edges.col(1) = mesh.vertex(face[2]) - mesh.vertex(face[0]);
    return edges;
  };
  const Eigen::Vector2d along = edges_of(from).colPivHouseholderQr().solve(direction);
  return tangentAt(to, place, edges_of(to) * along).value_or(anyTangentAt(to, place));
}

}  // namespace

transfer::PatchPlacement carriedAlong(const hand::Skin& from,
                                      const hand::Skin& to,
                                      const transfer::PatchPlacement& placement) {
  return {placement.root_S,
          directionOn(to.mesh(), from.mesh(), placement.root_S, placement.direction_S)};
}

optimize::PointPair carriedAlong(const hand::Skin& from,
                                 const hand::Skin& to,
                                 optimize::PointPair pair) {
  const geometry::SurfacePoint place_S = from.skinPointOf(pair.link, pair.p_L);
  const auto before = from.project(place_S);
  const auto now = to.project(place_S);
  if (!before || !now || before->link != pair.link || now->link != pair.link) return pair;
  // What lies beside the skin stays as far beside it.
  pair.p_L = now->p_L + (pair.p_L - before->p_L);
  return pair;
}

}  // namespace handgraft::sweep
