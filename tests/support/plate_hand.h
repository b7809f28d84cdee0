#pragma once

#include <memory>
#include <string>

#include "core/hand/hand_model.h"
#include "core/hand/skin.h"

namespace handgraft::test {

/// A hand of one link without joints.
inline std::shared_ptr<const hand::HandModel> makeRigidHand(
    const geometry::TriangleMesh& mesh_L) {
  hand::Link link;
  link.name = "plate";
  link.visuals.push_back({mesh_L, "test"});
  return std::make_shared<const hand::HandModel>("rigid", std::vector<hand::Link>{link},
                                                 std::vector<hand::Joint>{});
}

/// The skin of a rigid hand: any mesh near its link.
inline hand::Skin makeRigidSkin(const hand::HandModel& model,
                                const geometry::TriangleMesh& mesh_S) {
  return hand::Skin(model, mesh_S, Eigen::VectorXd(0), 0.004);
}

}  // namespace handgraft::test
