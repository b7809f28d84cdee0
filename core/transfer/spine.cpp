#include "core/transfer/spine.h"

#include "core/base/error.h"

namespace handgraft::transfer {

Spine spineOf(const geometry::TriangleMesh& /*object_O*/,
              const contact::Patch& patch,
              const Eigen::Vector3d& direction_O) {
  return {{{patch.root, direction_O}}, {}};
}

std::vector<std::optional<Station>> retraceMirrored(const geometry::TriangleMesh& /*skin_S*/,
                                                    const Station& root_S,
                                                    const std::vector<SpineLeg>& legs) {
  HANDGRAFT_REQUIRE(legs.empty());
  return {root_S};
}

}  // namespace handgraft::transfer
