#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/hand/skin.h"

namespace handgraft::hand {

/// Skin::project in a hundredth of its time, for searches: each face of the skin keeps the
/// plane of the link's surface beneath its middle.
///
/// On flat and on evenly curved parts it is off by hundredths of a millimetre; across an edge
/// of the link by as much as the face is wide, and along a border between links the face's
/// middle decides for all of it. Const, safe from several threads.
class SkinPlanes {
 public:
  /// Keeps `skin` by reference. Cost: some microseconds a face.
  explicit SkinPlanes(const Skin& skin);

  /// Of a place of the skin; nothing where its face's middle is of no link.
  [[nodiscard]] std::optional<LinkPoint> project(const geometry::SurfacePoint& place_S) const;

 private:
  /// Points of a skin's face go straight onto a plane of the link, which is turned into L then.
  struct Plane {
    LinkPoint point;  ///< of the face's middle; no link: none
    Eigen::Vector3d p_S = Eigen::Vector3d::Zero();
  };

  const Skin& skin_;
  std::vector<Plane> planes_;  ///< of each face
};

/// Those of a skin, made once for all who ask while it lives; they must not outlive it.
std::shared_ptr<const SkinPlanes> planesOf(const std::shared_ptr<const Skin>& skin);

}  // namespace handgraft::hand
