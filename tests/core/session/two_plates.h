#pragma once

#include <memory>
#include <utility>

#include "core/contact/segmentation.h"
#include "core/session/session.h"

#include "tests/support/plate_hand.h"
#include "tests/support/plates.h"

namespace handgraft::test {

/// Two disks 50 mm apart on a plate, and a rigid plate as a hand, whose sites are 40 mm apart:
/// 5 mm off, unless the roots slide.
struct TwoPlates {
  std::shared_ptr<const geometry::TriangleMesh> plate =
      std::make_shared<const geometry::TriangleMesh>(makePlate(100, 100, 0.001));
  contact::ContactSet contacts;
  hand::Hand hand;

  TwoPlates() {
    hand.model = makeRigidHand(*plate);
    hand.skin = std::make_shared<const hand::Skin>(makeRigidSkin(*hand.model, *plate));
    hand.sites_are_found = true;
    // Face to face: what is on the left here is on the right there.
    for (const auto& [name, side] : {std::pair{"thumb", -1.0}, std::pair{"index", 1.0}}) {
      contact::ContactMap map;
      map.mesh_O = *plate;
      map.value.resize(plate->vertexCount());
      const Eigen::Vector3d centre(side * 0.025, 0.0, 0.0);
      for (int v = 0; v < plate->vertexCount(); ++v)
        map.value[v] = (plate->vertex(v) - centre).norm() < 0.006 ? 1.0 : 0.0;
      contacts.patches.push_back(contact::segment(map, {}).patches.at(0));
      contacts.patches.back().name = name;
      contacts.patches.back().direction_O = Eigen::Vector3d::UnitY();
      hand.sites.push_back({name, "plate", Eigen::Vector3d(-side * 0.020, 0.0, 0.0),
                            Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitY()});
    }
  }

  [[nodiscard]] session::Session open() const {
    return {hand, plate, contacts, Pose::Identity(), {}};
  }
};

}  // namespace handgraft::test
