#include "core/session/solids.h"

#include <list>
#include <mutex>
#include <utility>

#include "core/base/error.h"

namespace handgraft::session {
namespace {

/// What was made of things that others own, for as long as those live.
template <class Owner, class Made>
class Memory {
 public:
  template <class Make>
  std::shared_ptr<const Made> get(const std::shared_ptr<const Owner>& owner, const Make& make) {
    const std::shared_ptr<Entry> entry = entryOf(owner);
    // One at a time: if it is cancelled, the next one who waits makes it.
    const std::lock_guard lock(entry->making);
    if (entry->made == nullptr) entry->made = make();
    return entry->made;
  }

 private:
  struct Entry {
    std::weak_ptr<const Owner> owner;
    std::mutex making;
    std::shared_ptr<const Made> made;
  };

  std::shared_ptr<Entry> entryOf(const std::shared_ptr<const Owner>& owner) {
    const std::lock_guard lock(mutex_);
    entries_.remove_if([](const auto& entry) {
      return entry->owner.expired();
    });
    for (const auto& entry : entries_)
      if (entry->owner.lock() == owner) return entry;
    entries_.push_back(std::make_shared<Entry>());
    entries_.back()->owner = owner;
    return entries_.back();
  }

  std::mutex mutex_;
  std::list<std::shared_ptr<Entry>> entries_;
};

}  // namespace

std::shared_ptr<const hand::HandSolid> solidOf(
    const std::shared_ptr<const hand::HandModel>& model,
    const std::shared_ptr<const hand::Skin>& skin,
    const Progress& progress) {
  HANDGRAFT_REQUIRE(model != nullptr && skin != nullptr);
  // By the model, since its rest pose counts, too; it comes with one skin.
  static Memory<hand::HandModel, hand::HandSolid> memory;
  return memory.get(model, [&] {
    return std::make_shared<const hand::HandSolid>(*model, *skin, progress);
  });
}

std::shared_ptr<const geometry::DistanceGrid> solidOf(
    const std::shared_ptr<const geometry::TriangleMesh>& object_O, const Progress& progress) {
  HANDGRAFT_REQUIRE(object_O != nullptr);
  static Memory<geometry::TriangleMesh, geometry::DistanceGrid> memory;
  return memory.get(object_O, [&] {
    return std::make_shared<const geometry::DistanceGrid>(
        std::make_shared<const geometry::SignedDistance>(*object_O),
        geometry::DistanceGridOptions(), progress);
  });
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
    const Progress& progress) {
  return quality::measurePenetration(*model, *solidOf(model, skin, progress),
                                     *solidOf(object_O, progress), X_WO, pose);
}

}  // namespace handgraft::session
