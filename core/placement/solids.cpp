#include "core/placement/solids.h"

#include "core/base/error.h"
#include "core/base/weak_cache.h"
#include "core/hand/kept_solid.h"

namespace handgraft::placement {

namespace {

/// By the model, since its rest pose counts, too; it comes with one skin.
WeakCache<hand::HandModel, hand::HandSolid>& handSolids() {
  static WeakCache<hand::HandModel, hand::HandSolid> memory;
  return memory;
}

}  // namespace

std::shared_ptr<const hand::HandSolid> solidOf(
    const std::shared_ptr<const hand::HandModel>& model,
    const std::shared_ptr<const hand::Skin>& skin,
    const Progress& progress) {
  HANDGRAFT_REQUIRE(model != nullptr && skin != nullptr);
  return handSolids().get(model, progress, [&] {
    return hand::keptSolid(*model, *skin, progress);
  });
}

void shareSolid(const std::shared_ptr<const hand::HandModel>& model,
                const std::shared_ptr<const hand::HandSolid>& solid) {
  HANDGRAFT_REQUIRE(model != nullptr && solid != nullptr);
  static_cast<void>(handSolids().get(model, Progress(), [&] {
    return solid;
  }));
}

std::shared_ptr<const geometry::Solid> solidOf(
    const std::shared_ptr<const geometry::TriangleMesh>& object_O, const Progress& progress) {
  HANDGRAFT_REQUIRE(object_O != nullptr);
  static WeakCache<geometry::TriangleMesh, geometry::Solid> memory;
  return memory.get(object_O, progress, [&] {
    return std::make_shared<const geometry::Solid>(*object_O, progress);
  });
}

std::shared_ptr<const geometry::SurfaceLocator> locatorOf(
    const std::shared_ptr<const geometry::TriangleMesh>& object_O) {
  HANDGRAFT_REQUIRE(object_O != nullptr);
  static WeakCache<geometry::TriangleMesh, geometry::SurfaceLocator> memory;
  return memory.get(object_O, Progress(), [&] {
    return std::make_shared<const geometry::SurfaceLocator>(*object_O);
  });
}

void makeSolids(const hand::Hand& hand,
                const std::shared_ptr<const geometry::TriangleMesh>& object_O,
                const Progress& progress) {
  static_cast<void>(solidOf(hand.model, hand.skin, progress));
  static_cast<void>(solidOf(object_O, progress));
}

std::shared_ptr<const optimize::Avoidance> avoidanceOf(
    const std::shared_ptr<const hand::HandModel>& model,
    const std::shared_ptr<const hand::Skin>& skin,
    const std::shared_ptr<const geometry::TriangleMesh>& object_O,
    const Pose& X_WO,
    const Progress& progress) {
  auto avoidance = std::make_shared<optimize::Avoidance>();
  avoidance->hand = solidOf(model, skin, progress);
  avoidance->object_O = solidOf(object_O, progress);
  avoidance->X_WO = X_WO;
  return avoidance;
}

quality::Penetration penetrationOf(
    const std::shared_ptr<const hand::HandModel>& model,
    const std::shared_ptr<const hand::Skin>& skin,
    const std::shared_ptr<const geometry::TriangleMesh>& object_O,
    const Pose& X_WO,
    const hand::HandPose& pose,
    const std::vector<quality::ContactSide>& sides,
    const Progress& progress) {
  return quality::measurePenetration(*model, *solidOf(model, skin, progress),
                                     *solidOf(object_O, progress), X_WO, pose, sides, progress);
}

double deepestOf(const std::shared_ptr<const hand::HandModel>& model,
                 const std::shared_ptr<const hand::Skin>& skin,
                 const std::shared_ptr<const geometry::TriangleMesh>& object_O,
                 const hand::HandPose& X_OH,
                 const Progress& progress,
                 const std::vector<quality::ContactSide>& sides) {
  return quality::measureDepth(*model, *solidOf(model, skin, progress),
                               *solidOf(object_O, progress), X_OH, progress, sides);
}

quality::Depths depthsOf(const std::shared_ptr<const hand::HandModel>& model,
                         const std::shared_ptr<const hand::Skin>& skin,
                         const std::shared_ptr<const geometry::TriangleMesh>& object_O,
                         const hand::HandPose& X_OH,
                         const Progress& progress,
                         const std::vector<quality::ContactSide>& sides) {
  return quality::measureDepths(*model, *solidOf(model, skin, progress),
                                *solidOf(object_O, progress), X_OH, progress, sides);
}

}  // namespace handgraft::placement
