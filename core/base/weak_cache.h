#pragma once

#include <chrono>
#include <condition_variable>
#include <exception>
#include <list>
#include <memory>
#include <mutex>
#include <utility>

#include "core/base/progress.h"

namespace handgraft {

/// What was made of things that others own, for as long as those live: made once, when first
/// asked for, and shared by all who ask. Safe from several threads; who asks for what another
/// one is making waits for it, and may be cancelled while it waits.
template <class Owner, class Made>
class WeakCache {
 public:
  /// `make` gives a std::shared_ptr<const Made>; what it throws is thrown here, and the next
  /// one who asks tries again. Errors: Cancelled on wish.
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

}  // namespace handgraft
