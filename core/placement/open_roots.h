#pragma once

#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "core/geometry/ball_tree.h"
#include "core/geometry/surface_point.h"
#include "core/hand/hand_model.h"
#include "core/hand/kinematics.h"
#include "core/hand/skin.h"

namespace handgraft::placement {

/// A skin's faces, link by link, to ask often where a posed hand shows a place.
class SkinFaces {
 public:
  /// Keeps a reference. Cost: O(F log^2 F).
  explicit SkinFaces(const hand::Skin& skin);

  struct Face {
    int face = -1;
    Eigen::Vector3d middle_S = Eigen::Vector3d::Zero();
    Eigen::Vector3d normal_S = Eigen::Vector3d::Zero();
  };

  /// Of one link, in the order of the balls around them.
  struct OfLink {
    std::vector<Face> faces;
    geometry::BallTree tree_S;
  };

  [[nodiscard]] const hand::Skin& skin() const { return skin_; }

  [[nodiscard]] const std::vector<OfLink>& links() const { return links_; }

 private:
  const hand::Skin& skin_;
  std::vector<OfLink> links_;
};

/// Made once for each skin, shared by all who hold it, and forgotten with it (weak_cache.h).
std::shared_ptr<const SkinFaces> facesOf(const std::shared_ptr<const hand::Skin>& skin);

/// The place of the skin that a posed hand shows to a place of an object: the middle of the
/// nearest face that looks at it, among those of the permitted links (of equally near ones the
/// first); nothing if none does.
///
/// Shapes: `X_SW` (Skin::fromWorld of the pose) and `permitted` one a link. Frames: place in W,
/// `n_W` the object's outward unit normal there. Cost: some 10 us.
std::optional<geometry::SurfacePoint> rootShownBy(const SkinFaces& faces,
                                                  const hand::LinkPoses& X_SW,
                                                  const std::vector<char>& permitted,
                                                  const Eigen::Vector3d& p_W,
                                                  const Eigen::Vector3d& n_W);

}  // namespace handgraft::placement
