#include "core/session/open_roots.h"

#include <algorithm>
#include <limits>

#include "core/session/made_once.h"

namespace handgraft::session {
namespace {

/// A face looks at a place if its normal is within 60 degrees of the other's opposite.
constexpr double kFacingCosine = 0.5;

}  // namespace

SkinFaces::SkinFaces(const hand::Skin& skin) : skin_(skin) {
  const geometry::TriangleMesh& mesh = skin.mesh();
  const std::vector<int>& owners = skin.faceLinks();
  if (owners.empty()) return;
  const int most = *std::max_element(owners.begin(), owners.end());
  links_.resize(static_cast<std::size_t>(std::max(most, -1) + 1));
  for (int f = 0; f < mesh.faceCount(); ++f) {
    const int link = owners[static_cast<std::size_t>(f)];
    if (link < 0) continue;
    const Eigen::Vector3i corners = mesh.face(f);
    OfLink& of = links_[static_cast<std::size_t>(link)];
    of.faces.push_back(f);
    of.middles_S.emplace_back(
        (mesh.vertex(corners[0]) + mesh.vertex(corners[1]) + mesh.vertex(corners[2])) / 3.0);
    of.normals_S.emplace_back(mesh.faceNormals().col(f));
  }
}

std::shared_ptr<const SkinFaces> facesOf(const std::shared_ptr<const hand::Skin>& skin) {
  static MadeOnce<hand::Skin, SkinFaces> memory;
  return memory.get(skin, Progress(), [&] {
    return std::make_shared<const SkinFaces>(*skin);
  });
}

std::optional<geometry::SurfacePoint> rootShownBy(const hand::HandModel& model,
                                                  const SkinFaces& faces,
                                                  const hand::HandPose& pose,
                                                  const std::vector<char>& permitted,
                                                  const Eigen::Vector3d& p_W,
                                                  const Eigen::Vector3d& n_W) {
  // Every link carries its part of the skin along: rather than that, the place is taken to
  // where each link has its skin at the reference pose.
  hand::LinkPoses X_SL;
  forwardKinematics(model, Pose::Identity(), faces.skin().qReference(), X_SL);
  const hand::LinkPoses X_WL = forwardKinematics(model, pose);
  std::optional<geometry::SurfacePoint> best;
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t link = 0; link < faces.links().size(); ++link) {
    if (permitted[link] == 0) continue;
    const Pose X_SW = X_SL[link] * inverse(X_WL[link]);
    const Eigen::Vector3d p_S = X_SW * p_W;
    const Eigen::Vector3d n_S = X_SW.linear() * n_W;
    const SkinFaces::OfLink& of = faces.links()[link];
    for (std::size_t i = 0; i < of.faces.size(); ++i) {
      if (of.normals_S[i].dot(n_S) > -kFacingCosine) continue;
      const double distance = (of.middles_S[i] - p_S).squaredNorm();
      if (distance >= nearest) continue;
      nearest = distance;
      best = geometry::SurfacePoint{of.faces[i], Eigen::Vector3d::Constant(1.0 / 3.0)};
    }
  }
  return best;
}

}  // namespace handgraft::session
