#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "hardware/safety/governor_types.h"

namespace handgraft::bridge {

/// A pose that its sender wants at a time, in the order of the hand's joints.
struct TimedPose {
  std::uint64_t stream = 0;
  std::int64_t source_ns = 0;  ///< when it is to be reached, on the sender's clock
  bool continues = false;      ///< of the same message as the one before
  safety::Time arrived{};
  std::vector<double> joint_rad;
};

/// Timed poses from one thread to another, each once and in order, without waiting, locks or,
/// where they have the joints that it was made for, allocation. One writer, one reader.
class TimedPoseRing {
 public:
  explicit TimedPoseRing(std::size_t joint_count) : slots_(kSlots) {
    for (TimedPose& slot : slots_)
      slot.joint_rad.resize(joint_count);
  }

  /// False, and nothing is kept, when nobody has taken any for long.
  bool put(const TimedPose& pose) {
    const std::size_t end = end_.load(std::memory_order_relaxed);
    if (end - begin_.load(std::memory_order_acquire) == kSlots) return false;
    slots_[end % kSlots] = pose;
    end_.store(end + 1, std::memory_order_release);
    return true;
  }

  /// The oldest that waits, valid until `drop`; null: none.
  [[nodiscard]] const TimedPose* front() const {
    const std::size_t begin = begin_.load(std::memory_order_relaxed);
    return begin == end_.load(std::memory_order_acquire) ? nullptr : &slots_[begin % kSlots];
  }

  void drop() {
    begin_.store(begin_.load(std::memory_order_relaxed) + 1, std::memory_order_release);
  }

 private:
  static constexpr std::size_t kSlots = 4096;  // a whole trajectory in one message

  std::vector<TimedPose> slots_;
  std::atomic<std::size_t> begin_{0};
  std::atomic<std::size_t> end_{0};
};

}  // namespace handgraft::bridge
