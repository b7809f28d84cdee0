#include "core/session/open_roots.h"

#include <limits>

namespace handgraft::session {
namespace {

/// A face looks at a place if its normal is within 60 degrees of the other's opposite.
constexpr double kFacingCosine = 0.5;

}  // namespace

std::optional<geometry::SurfacePoint> rootShownBy(const hand::HandModel& model,
                                                  const hand::Skin& skin,
                                                  const hand::HandPose& pose,
                                                  const std::vector<char>& permitted,
                                                  const Eigen::Vector3d& p_W,
                                                  const Eigen::Vector3d& n_W) {
  // Every link carries its part of the skin along: rather than that, the place is taken to
  // where each link has its skin at the reference pose.
  hand::LinkPoses X_SL;
  forwardKinematics(model, Pose::Identity(), skin.qReference(), X_SL);
  const hand::LinkPoses X_WL = forwardKinematics(model, pose);
  std::vector<Eigen::Vector3d> p_S(X_SL.size());
  std::vector<Eigen::Vector3d> n_S(X_SL.size());
  for (std::size_t link = 0; link < X_SL.size(); ++link) {
    const Pose X_SW = X_SL[link] * inverse(X_WL[link]);
    p_S[link] = X_SW * p_W;
    n_S[link] = X_SW.linear() * n_W;
  }

  const geometry::TriangleMesh& mesh = skin.mesh();
  std::optional<geometry::SurfacePoint> best;
  double nearest = std::numeric_limits<double>::infinity();
  for (int f = 0; f < mesh.faceCount(); ++f) {
    const int link = skin.faceLinks()[static_cast<std::size_t>(f)];
    if (link < 0 || permitted[static_cast<std::size_t>(link)] == 0) continue;
    if (mesh.faceNormals().col(f).dot(n_S[static_cast<std::size_t>(link)]) > -kFacingCosine)
      continue;
    const Eigen::Vector3i corners = mesh.face(f);
    const Eigen::Vector3d middle =
        (mesh.vertex(corners[0]) + mesh.vertex(corners[1]) + mesh.vertex(corners[2])) / 3.0;
    const double distance = (middle - p_S[static_cast<std::size_t>(link)]).squaredNorm();
    if (distance >= nearest) continue;
    nearest = distance;
    best = geometry::SurfacePoint{f, Eigen::Vector3d::Constant(1.0 / 3.0)};
  }
  return best;
}

}  // namespace handgraft::session
