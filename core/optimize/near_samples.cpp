#include "core/optimize/near_samples.h"

#include <numbers>

namespace handgraft::optimize {

double motionOf(const Pose& from,
                const Pose& to,
                const Eigen::Vector3d& centre,
                double radius) {
  // A rotation's difference from another one has two equal singular values and no third.
  const Eigen::Matrix3d turned = to.linear() - from.linear();
  const Eigen::Vector3d moved = to.translation() - from.translation();
  return (turned * centre + moved).norm() + turned.norm() / std::numbers::sqrt2 * radius;
}

void NearLists::startFor(const Source& now) {
  if (source == now) return;
  source = now;
  for (std::vector<NearSamples>* lists : {&in_object, &of_walls})
    for (NearSamples& near : *lists)
      near.forget();
  for (auto& pair : of_pairs)
    pair.reset();
}

}  // namespace handgraft::optimize
