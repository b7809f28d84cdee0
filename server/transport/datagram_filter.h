#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <span>
#include <utility>
#include <vector>

namespace handgraft::server {

/// Looks at every datagram before Fast DDS 2.9.1 does, which trusts too much: a submessage of
/// its maker's own kind ends the process by an assertion, a heartbeat that jumps by 2^60 spins
/// its thread for ever, a lease of no length crashes its discovery, and the size that the first
/// fragment of a sample announces is allocated.
///
/// What goes on is well-formed RTPS 2.x (OMG formal/2019-04-03, section 8.3 and 9.4) of the
/// kinds that our programs and ROS 2's use; submessages of other kinds are cut out, and a
/// datagram with a malformed one is dropped whole. One thing is mended on the way: see
/// `beginAnew` in the source. It knows nothing of who sends; that is for DDS Security.
///
/// Cost: one pass over the submessages' headers; memory for at most `kMostWriters` writers.
/// Threads: `pass` from any thread.
class DatagramFilter {
 public:
  static constexpr std::size_t kMostWriters = 20'000;
  /// How far ahead of what was seen of a writer its next sample may be.
  static constexpr std::int64_t kLongestJump = 10'000'000;
  /// How many samples a heartbeat may offer and a gap may skip.
  static constexpr std::int64_t kLongestRange = 1'000'000;
  static constexpr std::uint32_t kLargestSample = 64U << 20U;  ///< bytes
  static constexpr std::uint32_t kShortestLease_s = 5;

  /// What may go on of the datagram: nothing, all of it, or a copy in `kept`. The answer refers
  /// to one of both.
  std::span<const std::uint8_t> pass(std::span<const std::uint8_t> datagram,
                                     std::vector<std::uint8_t>& kept);

 private:
  using Prefix = std::array<std::uint8_t, 12>;

  struct Submessage;
  bool isSound(const Prefix& source, const Submessage& submessage);
  bool follows(const Prefix& source,
               std::uint32_t writer,
               std::int64_t first,
               std::int64_t last);

  std::mutex mutex_;
  /// The highest sample number seen of each writer.
  std::map<std::pair<Prefix, std::uint32_t>, std::int64_t> last_;
};

}  // namespace handgraft::server
