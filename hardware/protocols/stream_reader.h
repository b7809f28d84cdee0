#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>

#include "core/base/error.h"
#include "hardware/protocols/bytes.h"

namespace handgraft::protocols {

/// What a framing finds at the front of the bytes it is shown.
struct Cut {
  enum class Kind {
    kIncomplete,  ///< may become a frame with more bytes; `size` is 0
    kIdle,        ///< `size` bytes that belong to no frame and mean nothing
    kGarbage,     ///< `size` bytes that belong to no frame
    kDamaged,     ///< as kGarbage, but they looked like a frame until its checksum
    kFrame,       ///< a whole frame of `size` bytes
  };

  Kind kind = Kind::kIncomplete;
  std::size_t size = 0;
};

/// How a protocol marks its frames on a stream of bytes. `cut` looks at the front of `window`
/// (never empty) and puts a frame's content, unstuffed, into `frame`. It never answers
/// kIncomplete for `kLongest` bytes or more, and every other answer takes at least one byte.
template <class F>
concept Framing = requires(const F& framing, Bytes window, ByteBuffer& frame) {
  { framing.cut(window, frame) } -> std::same_as<Cut>;
  { F::kLongest } -> std::convertible_to<std::size_t>;
};

/// What came over a wire since the start.
struct StreamCounters {
  std::uint64_t frames = 0;
  std::uint64_t damaged = 0;        ///< frames whose checksum or stuffing was wrong
  std::uint64_t garbage_bytes = 0;  ///< bytes skipped to find the next frame
};

/// Finds the frames in a stream of bytes, however it is split, and finds its way back after
/// anything else. One for all protocols; `F` knows what a frame is.
///
/// Cost: no allocation, a fixed store; O(bytes) unless frames come in crumbs.
template <Framing F>
class StreamReader {
 public:
  explicit StreamReader(F framing = {}) : framing_(framing) {}

  /// Calls `use(frame)` with the content of each frame that `bytes` complete, in their order.
  template <class Use>
  void feed(Bytes bytes, Use&& use) {
    while (!bytes.empty()) {
      const std::size_t count = std::min(bytes.size(), store_.size() - size_);
      std::copy_n(bytes.begin(), count, store_.begin() + static_cast<std::ptrdiff_t>(size_));
      size_ += count;
      bytes = bytes.subspan(count);
      scan(use);
    }
  }

  /// Says that nothing follows what has come so far: a frame that was begun is none, and frames
  /// hidden behind its false start are found.
  template <class Use>
  void settle(Use&& use) {
    while (size_ > 0) {
      drop(1);
      ++counters_.garbage_bytes;
      scan(use);
    }
  }

  /// Forgets a frame that was begun.
  void clear() { size_ = 0; }

  /// Bytes kept of a frame that was begun; less than F::kLongest.
  [[nodiscard]] std::size_t pending() const { return size_; }

  [[nodiscard]] const StreamCounters& counters() const { return counters_; }

 private:
  template <class Use>
  void scan(Use& use) {
    while (size_ > 0) {
      const Cut cut = framing_.cut({store_.data(), size_}, frame_);
      if (cut.kind == Cut::Kind::kIncomplete) {
        HANDGRAFT_REQUIRE(size_ < F::kLongest);
        return;
      }
      HANDGRAFT_REQUIRE(cut.size > 0 && cut.size <= size_);
      drop(cut.size);
      if (cut.kind == Cut::Kind::kGarbage) counters_.garbage_bytes += cut.size;
      if (cut.kind == Cut::Kind::kDamaged) {
        ++counters_.damaged;
        counters_.garbage_bytes += cut.size;
      }
      if (cut.kind != Cut::Kind::kFrame) continue;
      ++counters_.frames;
      use(frame_.bytes());
    }
  }

  void drop(std::size_t count) {
    std::copy(store_.begin() + static_cast<std::ptrdiff_t>(count),
              store_.begin() + static_cast<std::ptrdiff_t>(size_), store_.begin());
    size_ -= count;
  }

  F framing_;
  std::array<std::uint8_t, 2 * F::kLongest> store_;
  std::size_t size_ = 0;
  ByteBuffer frame_;
  StreamCounters counters_;
};

}  // namespace handgraft::protocols
