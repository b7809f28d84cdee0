#include "core/hand/skin_planes.h"

#include <algorithm>

#include "core/base/parallel_for.h"
#include "core/base/weak_cache.h"

namespace handgraft::hand {

namespace {

constexpr int kAtOnce = 1000;  // faces

}  // namespace

SkinPlanes::SkinPlanes(const Skin& skin) : skin_(skin) {
  const int count = skin.mesh().faceCount();
  planes_.resize(static_cast<std::size_t>(count));
  parallelFor((count + kAtOnce - 1) / kAtOnce, [&](int part) {
    const int end = std::min(count, (part + 1) * kAtOnce);
    for (int f = part * kAtOnce; f < end; ++f) {
      const geometry::SurfacePoint middle{f, Eigen::Vector3d::Constant(1.0 / 3.0)};
      const std::optional<LinkPoint> point = skin.project(middle);
      if (!point) continue;
      planes_[static_cast<std::size_t>(f)] = {*point, positionOf(skin.mesh(), middle)};
    }
  });
}

std::optional<LinkPoint> SkinPlanes::project(const geometry::SurfacePoint& place_S) const {
  const Plane& plane = planes_[static_cast<std::size_t>(place_S.face)];
  if (plane.point.link < 0) return std::nullopt;
  LinkPoint result = plane.point;
  const Eigen::Vector3d step_L =
      skin_.directionInLink(result.link, positionOf(skin_.mesh(), place_S) - plane.p_S);
  result.p_L += step_L - step_L.dot(result.n_L) * result.n_L;
  return result;
}

std::shared_ptr<const SkinPlanes> planesOf(const std::shared_ptr<const Skin>& skin) {
  static WeakCache<Skin, SkinPlanes> memory;
  return memory.get(skin, Progress(), [&] {
    return std::make_shared<const SkinPlanes>(*skin);
  });
}

}  // namespace handgraft::hand
