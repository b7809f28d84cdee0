#pragma once

#include <array>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <list>
#include <map>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <vector>

namespace handgraft::server {

/// Datagrams on their way from a socket to whoever works on them, by turns of the sockets that
/// sent them (fair queuing, Nagle 1985): who sends many has his own wait, not others'. What is
/// beyond a sender's part is left out, as a full socket leaves it out, and DDS sends it again.
///
/// What tells where a sender stands (sender_state.h) takes the place of what told the same
/// before and still waits, and heartbeats have a quarter of the turns, unless nothing else
/// waits. Cyclone DDS says one 50 times a second for each of its writers that is not answered,
/// so that behind a busy moment of the server its samples waited for minutes among those, which
/// for their part went on.
///
/// Threads: all methods from any. Cost: a copy of each datagram; O(log senders).
class FairQueue {
 public:
  /// As a socket names it: address and port. What a datagram says of its sender is not asked,
  /// since anybody may write there what he likes.
  struct Sender {
    std::array<std::uint8_t, 16> address{};
    std::uint32_t port = 0;

    bool operator==(const Sender&) const = default;

    bool operator<(const Sender& other) const {
      return std::tie(address, port) < std::tie(other.address, other.port);
    }
  };

  struct Datagram {
    Sender sender;
    std::vector<std::uint8_t> bytes;
  };

  /// So much of one sender waits at most: a saved session of 16 MiB comes in pieces that are
  /// worked on as they come.
  static constexpr std::size_t kMostBytesOfOne = 4U << 20U;
  static constexpr std::size_t kMostBytes = 64U << 20U;

  explicit FairQueue(std::size_t most_bytes_of_one = kMostBytesOfOne,
                     std::size_t most_bytes = kMostBytes)
      : most_bytes_of_one_(most_bytes_of_one), most_bytes_(most_bytes) {}

  /// False, and it is not kept, where the sender has too much waiting. Where all together have,
  /// the newest of who has most goes.
  bool push(const Sender& sender, std::span<const std::uint8_t> bytes);

  /// The next one whose turn it is; waits for it. Nothing once the queue is shut.
  std::optional<Datagram> pop();

  void shut();

  /// Of all that waits.
  [[nodiscard]] std::size_t bytes() const;

 private:
  struct Kept {
    std::vector<std::uint8_t> bytes;
    std::string state;  ///< SenderState::key
  };

  using Line = std::list<Kept>;

  /// Of one sender.
  struct Waiting {
    Line heartbeats;
    Line others;
    std::map<std::string, Line::iterator> states;  ///< of both, those that tell where it stands
    std::size_t bytes = 0;
  };

  using AllWaiting = std::map<Sender, Waiting>;

  /// Of memory.
  static std::size_t costOf(const Kept& one);
  /// One of a sender's; `mutex_` held.
  std::vector<std::uint8_t> take(Waiting& waiting, Line& line, Line::iterator which);
  /// Of a sender of whom nothing waits any more; likewise.
  void tidy(AllWaiting::iterator whose);

  const std::size_t most_bytes_of_one_;
  const std::size_t most_bytes_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  AllWaiting waiting_;  ///< of those who have something waiting
  // Likewise, whose turn it is first.
  std::list<Sender> turns_;
  std::list<Sender> turns_of_heartbeats_;
  unsigned taken_ = 0;
  std::size_t bytes_ = 0;  ///< of all
  bool is_shut_ = false;
};

}  // namespace handgraft::server
