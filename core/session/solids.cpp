#include "core/session/solids.h"

#include <chrono>
#include <condition_variable>
#include <exception>
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
  std::shared_ptr<const Made> get(const std::shared_ptr<const Owner>& owner,
                                  const Progress& progress,
                                  const Make& make) {
    constexpr std::chrono::milliseconds kGlance(20);
    const std::shared_ptr<Entry> entry = entryOf(owner);
    std::unique_lock lock(entry->mutex);
    while (entry->made == nullptr) {
      progress.checkpoint();
      if (entry->being_made) {
        entry->changed.wait_for(lock, kGlance);
        continue;
      }
      entry->being_made = true;
      lock.unlock();
      std::shared_ptr<const Made> made;
      std::exception_ptr failure;
      try {
        made = make();
      } catch (...) {  // the next one who waits makes it
        failure = std::current_exception();
      }
      lock.lock();
      entry->being_made = false;
      entry->made = std::move(made);
      entry->changed.notify_all();
      if (failure) std::rethrow_exception(failure);
    }
    return entry->made;
  }

 private:
  struct Entry {
    std::weak_ptr<const Owner> owner;
    std::mutex mutex;
    std::condition_variable changed;
    bool being_made = false;
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
  return memory.get(model, progress, [&] {
    return std::make_shared<const hand::HandSolid>(*model, *skin, progress);
  });
}

std::shared_ptr<const geometry::DistanceGrid> solidOf(
    const std::shared_ptr<const geometry::TriangleMesh>& object_O, const Progress& progress) {
  HANDGRAFT_REQUIRE(object_O != nullptr);
  static Memory<geometry::TriangleMesh, geometry::DistanceGrid> memory;
  return memory.get(object_O, progress, [&] {
    return std::make_shared<const geometry::DistanceGrid>(
        std::make_shared<const geometry::SignedDistance>(*object_O),
        geometry::DistanceGridOptions(), progress);
  });
}

void makeSolids(const Hand& hand,
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
    const Progress& progress) {
  return quality::measurePenetration(*model, *solidOf(model, skin, progress),
                                     *solidOf(object_O, progress), X_WO, pose);
}

}  // namespace handgraft::session
