#pragma once

#include <array>
#include <atomic>

namespace handgraft::bridge {

/// Hands values from one thread to another, the newest wins: neither side ever waits, locks or,
/// where assigning a T does not, allocates. One writer, one reader.
///
/// Three slots: the writer's draft, the reader's, and the one in between that they swap theirs
/// with.
template <class T>
class TripleBuffer {
 public:
  explicit TripleBuffer(const T& initial = T()) : slots_{initial, initial, initial} {}

  TripleBuffer(const TripleBuffer&) = delete;
  TripleBuffer& operator=(const TripleBuffer&) = delete;

  /// Writer: what the next `publish` hands over. Holds an older value until it is written.
  T& draft() { return slots_[draft_]; }

  void publish() {
    draft_ = between_.exchange(draft_ | kFresh, std::memory_order_acq_rel) & kIndex;
  }

  /// Reader: the newest value if there is one not yet taken, else null. Valid until the next
  /// call.
  const T* take() {
    if ((between_.load(std::memory_order_relaxed) & kFresh) == 0) return nullptr;
    taken_ = between_.exchange(taken_, std::memory_order_acq_rel) & kIndex;
    return &slots_[taken_];
  }

  /// Reader: what was taken last; the initial value before.
  [[nodiscard]] const T& last() const { return slots_[taken_]; }

 private:
  static constexpr unsigned kFresh = 4;  // set in `between_` while nobody has taken it
  static constexpr unsigned kIndex = 3;

  std::array<T, 3> slots_;
  unsigned draft_ = 0;
  unsigned taken_ = 1;
  std::atomic<unsigned> between_{2};
  static_assert(std::atomic<unsigned>::is_always_lock_free);
};

}  // namespace handgraft::bridge
