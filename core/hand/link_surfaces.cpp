#include "core/hand/link_surfaces.h"

namespace handgraft::hand {

const std::vector<Shape>& surfaceOf(const Link& link, SurfaceSource source) {
  if (source == SurfaceSource::kVisuals) return link.surface();
  return link.collisions.empty() ? link.visuals : link.collisions;
}

LinkSurfaces linkSurfaces(const HandModel& model, const LinkPoses& X_AL, SurfaceSource source) {
  LinkSurfaces all;
  std::vector<geometry::TriangleMesh> meshes;
  for (int link = 0; link < model.linkCount(); ++link) {
    const Eigen::Affine3d affine_X_AL(X_AL[static_cast<std::size_t>(link)].matrix());
    for (const Shape& shape :
         surfaceOf(model.links()[static_cast<std::size_t>(link)], source)) {
      if (shape.mesh_L.faceCount() == 0) continue;
      meshes.push_back(geometry::transformed(shape.mesh_L, affine_X_AL));
      all.face_links.insert(all.face_links.end(),
                            static_cast<std::size_t>(shape.mesh_L.faceCount()), link);
    }
  }
  if (!meshes.empty()) all.mesh_A = geometry::merged(meshes);
  return all;
}

}  // namespace handgraft::hand
