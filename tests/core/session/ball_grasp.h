#pragma once

#include <cmath>

#include "core/contact/segmentation.h"
#include "core/session/session.h"

#include "tests/support/small_hand.h"

namespace handgraft::test {

/// A ball of 30 mm radius, touched by three fingertips from both sides, as the small hand can.
struct BallGrasp {
  SmallHand small = sharedHand();
  std::shared_ptr<const geometry::TriangleMesh> ball = sharedBall();
  contact::ContactSet contacts;

  /// `names`: of the patches at thumb, index, middle, and between those two; directions (to the
  /// hand's root, -z) are set unless `open`.
  explicit BallGrasp(const std::vector<std::string>& names = {"thumb", "index", "middle"},
                     bool open = false) {
    const std::vector<Eigen::Vector3d> roots = {{-1, 0, 0},
                                                {std::cos(0.55), std::sin(0.55), 0},
                                                {std::cos(0.55), -std::sin(0.55), 0},
                                                {1, 0, 0}};
    for (std::size_t i = 0; i < names.size(); ++i) {
      contact::ContactMap map;
      map.mesh_O = *ball;
      map.value = Eigen::VectorXd::Zero(ball->vertexCount());
      for (int v = 0; v < ball->vertexCount(); ++v) {
        const double arc = 0.03 * std::acos(ball->vertex(v).normalized().dot(roots[i]));
        map.value[v] = arc < 0.007 ? 1.0 : 0.0;
      }
      contact::Patch patch = contact::segment(map, {}).patches.at(0);
      patch.name = names[i];
      if (!open) patch.direction_O = -Eigen::Vector3d::UnitZ();
      contacts.patches.push_back(patch);
    }
    contacts.name = "ball";
  }

  // The same for all tests, since solids are made once for a hand and an object.
  static const SmallHand& sharedHand() {
    static const SmallHand hand = makeSmallHand();
    return hand;
  }

  static const std::shared_ptr<const geometry::TriangleMesh>& sharedBall() {
    static const auto ball =
        std::make_shared<const geometry::TriangleMesh>(geometry::makeSphere(0.03, 5));
    return ball;
  }

  [[nodiscard]] hand::Hand hand() const { return {small.model, small.skin, small.sites}; }

  [[nodiscard]] session::Session open(const Pose& X_WO = Pose::Identity()) const {
    return {hand(), ball, contacts, X_WO, {}};
  }
};

}  // namespace handgraft::test
