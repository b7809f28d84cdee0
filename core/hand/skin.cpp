#include "core/hand/skin.h"

#include <cmath>
#include <utility>

#include "core/base/error.h"
#include "core/hand/kinematics.h"
#include "core/hand/link_surfaces.h"

namespace handgraft::hand {

namespace {

/// Cosine of 60 degrees: a link's face that leans farther from the skin than this is an edge,
/// an inner wall or a badly oriented triangle, not the side that the skin covers.
constexpr double kAgreeingCosine = 0.5;

}  // namespace

LinkSurfaces linkSurfaces(const HandModel& model, const LinkPoses& X_AL) {
  LinkSurfaces all;
  std::vector<geometry::TriangleMesh> meshes;
  for (int link = 0; link < model.linkCount(); ++link) {
    const Eigen::Affine3d X_AL_affine(X_AL[static_cast<std::size_t>(link)].matrix());
    for (const Shape& shape : model.links()[static_cast<std::size_t>(link)].surface()) {
      if (shape.mesh_L.faceCount() == 0) continue;
      meshes.push_back(geometry::transformed(shape.mesh_L, X_AL_affine));
      all.face_links.insert(all.face_links.end(),
                            static_cast<std::size_t>(shape.mesh_L.faceCount()), link);
    }
  }
  if (!meshes.empty()) all.mesh_A = geometry::merged(meshes);
  return all;
}

Skin::Skin(const HandModel& model,
           geometry::TriangleMesh mesh_S,
           Eigen::VectorXd q_reference,
           double epsilon_m)
    : mesh_S_(std::move(mesh_S)), q_reference_(std::move(q_reference)), epsilon_m_(epsilon_m) {
  HANDGRAFT_REQUIRE(q_reference_.size() == model.dofCount());
  if (!(epsilon_m_ > 0.0) || !std::isfinite(epsilon_m_))
    rejectInput("skin: epsilon {} m must be positive", epsilon_m_);
  forwardKinematics(model, Pose::Identity(), q_reference_, X_SL_);
  LinkSurfaces links = linkSurfaces(model, X_SL_);
  if (links.mesh_A.faceCount() == 0)
    rejectInput("hand {}: none of its links has a surface", quoted(model.name()));
  face_links_ = std::move(links.face_links);
  locator_ = std::make_unique<geometry::SurfaceLocator>(mesh_S_);
  links_locator_ = std::make_unique<geometry::SurfaceLocator>(links.mesh_A);
}

std::optional<LinkPoint> Skin::project(const Eigen::Vector3d& p_S,
                                       const Eigen::Vector3d& n_S) const {
  if (!p_S.allFinite()) return std::nullopt;
  const geometry::SurfaceLocator::Hit hit = links_locator_->nearest(p_S);
  if (!(hit.distance <= epsilon_m_)) return std::nullopt;

  // A thin or turned surface shows its other side; its plane is right nevertheless.
  Eigen::Vector3d n_link_S = links_locator_->mesh().faceNormals().col(hit.point.face);
  if (n_link_S.dot(n_S) < 0.0) n_link_S = -n_link_S;
  if (n_link_S.dot(n_S) < kAgreeingCosine) n_link_S = n_S;

  LinkPoint result;
  result.link = face_links_[static_cast<std::size_t>(hit.point.face)];
  const Pose X_LS = inverse(X_SL_[static_cast<std::size_t>(result.link)]);
  result.p_L = X_LS * hit.position;
  result.n_L = (X_LS.linear() * n_link_S).normalized();
  result.distance_m = hit.distance;
  return result;
}

geometry::SurfacePoint Skin::skinPointOf(int link, const Eigen::Vector3d& p_L) const {
  HANDGRAFT_REQUIRE(link >= 0 && static_cast<std::size_t>(link) < X_SL_.size());
  return locator_->nearest(X_SL_[static_cast<std::size_t>(link)] * p_L).point;
}

Eigen::Vector3d Skin::directionInSkin(int link, const Eigen::Vector3d& d_L) const {
  HANDGRAFT_REQUIRE(link >= 0 && static_cast<std::size_t>(link) < X_SL_.size());
  return X_SL_[static_cast<std::size_t>(link)].linear() * d_L;
}

}  // namespace handgraft::hand
