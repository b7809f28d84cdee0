#include "core/hand/skin.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/error.h"
#include "core/hand/link_surfaces.h"

namespace handgraft::hand {

namespace {

/// Cosine of 60 degrees: a link's face that leans farther from the skin than this is an edge,
/// an inner wall or a badly oriented triangle, not the side that the skin covers.
constexpr double kAgreeingCosine = 0.5;

}  // namespace

Skin::Skin(const HandModel& model,
           geometry::TriangleMesh mesh_S,
           Eigen::VectorXd q_reference,
           double epsilon_m,
           SurfaceSource source)
    : Skin(model, std::move(mesh_S), std::move(q_reference), epsilon_m, source, {}) {
  face_links_ = linksOfFaces(mesh_S_, *links_, epsilon_m_);
}

Skin::Skin(const HandModel& model,
           geometry::TriangleMesh mesh_S,
           Eigen::VectorXd q_reference,
           double epsilon_m,
           SurfaceSource source,
           std::vector<int> face_links)
    : mesh_S_(std::move(mesh_S)),
      q_reference_(std::move(q_reference)),
      epsilon_m_(epsilon_m),
      source_(source),
      face_links_(std::move(face_links)) {
  HANDGRAFT_REQUIRE(q_reference_.size() == model.dofCount());
  if (!(epsilon_m_ > 0.0) || !std::isfinite(epsilon_m_))
    rejectInput("skin: epsilon {} m must be positive", epsilon_m_);
  forwardKinematics(model, Pose::Identity(), q_reference_, X_SL_);
  const LinkSurfaces links = linkSurfaces(model, X_SL_, source);
  if (links.mesh_A.faceCount() == 0)
    rejectInput("hand {}: none of its links has a surface", quoted(model.name()));
  locator_ = std::make_unique<geometry::SurfaceLocator>(mesh_S_);
  links_ = std::make_unique<LinkLocators>(links, model.linkCount());
}

std::optional<LinkLocators::Hit> Skin::hitFrom(int face,
                                               const Eigen::Vector3d& p_S,
                                               const Eigen::Vector3d& n_S) const {
  // Along a border between links, the place itself decides among those that meet there.
  std::vector<int> links;
  for (int corner = 0; corner < 3; ++corner) {
    const int v = mesh_S_.face(face)[corner];
    for (const int* h = mesh_S_.outgoingBegin(v); h != mesh_S_.outgoingEnd(v); ++h) {
      const int link =
          face_links_[static_cast<std::size_t>(geometry::TriangleMesh::faceOf(*h))];
      if (link >= 0 && std::find(links.begin(), links.end(), link) == links.end())
        links.push_back(link);
    }
  }
  if (links.empty()) return links_->nearest(p_S, epsilon_m_);
  std::optional<LinkLocators::Hit> best;
  for (const int link : links) {
    const auto hit = links_->nearestOf(link, p_S, epsilon_m_);
    if (hit && (!best || misfit(*hit, p_S, n_S) < misfit(*best, p_S, n_S))) best = hit;
  }
  return best;
}

std::optional<LinkPoint> Skin::project(const Eigen::Vector3d& p_S,
                                       const Eigen::Vector3d& n_S) const {
  if (!p_S.allFinite()) return std::nullopt;
  return projectFrom(locator_->nearest(p_S).point.face, p_S, n_S);
}

std::optional<LinkPoint> Skin::project(const geometry::SurfacePoint& place_S) const {
  return projectFrom(place_S.face, positionOf(mesh_S_, place_S), normalOf(mesh_S_, place_S));
}

std::optional<LinkPoint> Skin::projectFrom(int face,
                                           const Eigen::Vector3d& p_S,
                                           const Eigen::Vector3d& n_S) const {
  const std::optional<LinkLocators::Hit> hit = hitFrom(face, p_S, n_S);
  if (!hit) return std::nullopt;

  // A thin or turned surface shows its other side; its plane is right nevertheless.
  Eigen::Vector3d n_link_S = hit->n_S;
  if (n_link_S.dot(n_S) < 0.0) n_link_S = -n_link_S;
  if (n_link_S.dot(n_S) < kAgreeingCosine) n_link_S = n_S;

  LinkPoint result;
  result.link = hit->link;
  const Pose X_LS = inverse(X_SL_[static_cast<std::size_t>(result.link)]);
  result.p_L = X_LS * hit->position_S;
  result.n_L = (X_LS.linear() * n_link_S).normalized();
  result.distance_m = hit->distance_m;
  return result;
}

LinkPoses Skin::fromWorld(const HandModel& model, const HandPose& pose) const {
  LinkPoses X_SW = forwardKinematics(model, pose);
  for (std::size_t i = 0; i < X_SW.size(); ++i)
    X_SW[i] = X_SL_[i] * inverse(X_SW[i]);
  return X_SW;
}

geometry::SurfacePoint Skin::skinPointOf(int link, const Eigen::Vector3d& p_L) const {
  HANDGRAFT_REQUIRE(link >= 0 && static_cast<std::size_t>(link) < X_SL_.size());
  return locator_->nearest(X_SL_[static_cast<std::size_t>(link)] * p_L).point;
}

Eigen::Vector3d Skin::directionInSkin(int link, const Eigen::Vector3d& d_L) const {
  HANDGRAFT_REQUIRE(link >= 0 && static_cast<std::size_t>(link) < X_SL_.size());
  return X_SL_[static_cast<std::size_t>(link)].linear() * d_L;
}

Eigen::Vector3d Skin::directionInLink(int link, const Eigen::Vector3d& d_S) const {
  HANDGRAFT_REQUIRE(link >= 0 && static_cast<std::size_t>(link) < X_SL_.size());
  return X_SL_[static_cast<std::size_t>(link)].linear().transpose() * d_S;
}

}  // namespace handgraft::hand
