#include "core/optimize/near_samples.h"

#include <numbers>

namespace handgraft::optimize {

double motionOf(const Pose& from,
                const Pose& to,
                const Eigen::Vector3d& centre,
                double radius) {
  // A rotation's difference from another one has two equal singular values and no third.
  const double turn = (to.linear() - from.linear()).norm() / std::numbers::sqrt2;
  return (to * centre - from * centre).norm() + turn * radius;
}

void NearLists::forget() {
  for (std::vector<NearSamples>* lists : {&in_object, &of_walls})
    for (NearSamples& near : *lists)
      near.forget();
  for (auto& pair : of_pairs)
    pair.reset();
}

}  // namespace handgraft::optimize
