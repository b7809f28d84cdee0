#include "core/placement/open_roots.h"

#include <algorithm>
#include <limits>

#include "core/base/weak_cache.h"

namespace handgraft::placement {
namespace {

/// A face looks at a place if its normal is within 60 degrees of the other's opposite.
constexpr double kFacingCosine = 0.5;

// One face in so many says how near the nearest one is at least: the others' balls are passed
// over then.
constexpr std::size_t kLookAhead = 64;

/// The nearest face that looks at a place.
class Nearest {
 public:
  void lookFrom(const Eigen::Vector3d& p_S, const Eigen::Vector3d& n_S) {
    p_S_ = p_S;
    n_S_ = n_S;
  }

  void searchIn(const SkinFaces::OfLink& link) {
    for (std::size_t i = 0; i < link.faces.size(); i += kLookAhead)
      offer(link.faces[i]);
    link.tree_S.visit(
        [&](const Eigen::Vector3d& centre_S, double radius) {
          const double way = (centre_S - p_S_).norm() - radius;
          return way > 0.0 && way * way > squared_;
        },
        [&](int begin, int end) {
          for (int i = begin; i < end; ++i)
            offer(link.faces[static_cast<std::size_t>(i)]);
        });
  }

  /// -1: none.
  [[nodiscard]] int face() const { return face_; }

 private:
  void offer(const SkinFaces::Face& face) {
    const double squared = (face.middle_S - p_S_).squaredNorm();
    if (squared > squared_ || (squared == squared_ && face.face >= face_)) return;
    if (face.normal_S.dot(n_S_) > -kFacingCosine) return;
    squared_ = squared;
    face_ = face.face;
  }

  Eigen::Vector3d p_S_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d n_S_ = Eigen::Vector3d::Zero();
  double squared_ = std::numeric_limits<double>::infinity();
  int face_ = -1;
};

}  // namespace

SkinFaces::SkinFaces(const hand::Skin& skin) : skin_(skin) {
  const geometry::TriangleMesh& mesh = skin.mesh();
  const std::vector<int>& owners = skin.faceLinks();
  if (owners.empty()) return;
  const int most = *std::max_element(owners.begin(), owners.end());
  links_.resize(static_cast<std::size_t>(std::max(most + 1, 0)));
  for (int f = 0; f < mesh.faceCount(); ++f) {
    const int link = owners[static_cast<std::size_t>(f)];
    if (link < 0) continue;
    const Eigen::Vector3i corners = mesh.face(f);
    links_[static_cast<std::size_t>(link)].faces.push_back(
        {f, (mesh.vertex(corners[0]) + mesh.vertex(corners[1]) + mesh.vertex(corners[2])) / 3.0,
         mesh.faceNormals().col(f)});
  }
  for (OfLink& of : links_) {
    Eigen::Matrix3Xd middles(3, std::ssize(of.faces));
    for (Eigen::Index i = 0; i < middles.cols(); ++i)
      middles.col(i) = of.faces[static_cast<std::size_t>(i)].middle_S;
    std::vector<int> order;
    of.tree_S = geometry::BallTree(middles, order);
    const std::vector<Face> before = of.faces;
    for (std::size_t i = 0; i < order.size(); ++i)
      of.faces[i] = before[static_cast<std::size_t>(order[i])];
  }
}

std::shared_ptr<const SkinFaces> facesOf(const std::shared_ptr<const hand::Skin>& skin) {
  static WeakCache<hand::Skin, SkinFaces> memory;
  return memory.get(skin, Progress(), [&] {
    return std::make_shared<const SkinFaces>(*skin);
  });
}

std::optional<geometry::SurfacePoint> rootShownBy(const SkinFaces& faces,
                                                  const hand::LinkPoses& X_SW,
                                                  const std::vector<char>& permitted,
                                                  const Eigen::Vector3d& p_W,
                                                  const Eigen::Vector3d& n_W) {
  Nearest nearest;
  for (std::size_t link = 0; link < faces.links().size(); ++link) {
    if (permitted[link] == 0) continue;
    nearest.lookFrom(X_SW[link] * p_W, X_SW[link].linear() * n_W);
    nearest.searchIn(faces.links()[link]);
  }
  if (nearest.face() < 0) return std::nullopt;
  return geometry::SurfacePoint{nearest.face(), Eigen::Vector3d::Constant(1.0 / 3.0)};
}

}  // namespace handgraft::placement
