#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace handgraft::bridge {

/// What people may ask of a hand, besides an emergency stop, which does not queue.
enum class Request : std::uint8_t { kArm, kDisarm, kReset, kHome };

/// Requests from one thread to another, each once and in order, without waiting or locks. One
/// writer, one reader.
class RequestRing {
 public:
  /// False, and nothing is kept, when 64 wait already: nobody has taken any for long.
  bool put(Request request) {
    const std::size_t end = end_.load(std::memory_order_relaxed);
    if (end - begin_.load(std::memory_order_acquire) == slots_.size()) return false;
    slots_[end % slots_.size()] = request;
    end_.store(end + 1, std::memory_order_release);
    return true;
  }

  std::optional<Request> take() {
    const std::size_t begin = begin_.load(std::memory_order_relaxed);
    if (begin == end_.load(std::memory_order_acquire)) return std::nullopt;
    const Request request = slots_[begin % slots_.size()];
    begin_.store(begin + 1, std::memory_order_release);
    return request;
  }

 private:
  std::array<Request, 64> slots_{};
  std::atomic<std::size_t> begin_{0};
  std::atomic<std::size_t> end_{0};
};

}  // namespace handgraft::bridge
