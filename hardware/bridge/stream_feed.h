#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hardware/bridge/solution_follower.h"

namespace handgraft::bridge {

/// What becomes of sessions and servers on the way to a hand: one stream of poses, and whether
/// it lives.
///
/// A stream is one session in one server's life. Its number grows with each that is followed,
/// so that a pose of another session, or of a server that started anew, is never taken for one
/// of the stream before. A stream lives while a server is there and its session is open; with
/// `outlives_closing`, until the server goes. One that follows a demonstrator lives while
/// frames are answered: what is left of it half a second later moves nobody.
class StreamFeed {
 public:
  using Time = std::chrono::steady_clock::time_point;

  struct Pose {
    std::uint64_t stream = 0;
    /// The joints are those of the pose before in this stream: a final pose comes again once it
    /// is diagnosed, which is nothing new for a hand.
    bool is_repeat = false;
    FollowedPose pose;
  };

  /// `only`: the one session to follow. `hand`: the one hand whose sessions are followed;
  /// empty: any.
  StreamFeed(std::optional<std::uint64_t> only,
             bool with_intermediate,
             bool outlives_closing,
             std::string hand = {});

  /// False if the session is of another hand, and passed over. If it was the one followed, its
  /// stream ends: should its hand come back, that is another stream.
  bool see(const v1::SessionState& state);

  /// As SolutionFollower's.
  void see(const v1::PoseSolution& solution, std::int64_t written_ns = 0) {
    follower_.see(solution, written_ns);
  }

  std::optional<std::uint64_t> takeKept() { return follower_.takeKept(); }

  std::optional<std::uint64_t> takeLeft() { return follower_.takeLeft(); }

  std::optional<std::uint64_t> takeBeside() { return follower_.takeBeside(); }

  /// Of the session followed, from its server after a restart: the upper half of a pose's
  /// number tells the server's lives apart (idl/TOPICS.md).
  [[nodiscard]] bool isAnew(const v1::PoseSolution& solution) const;

  /// The stream that timed samples of this session belong to.
  struct Heard {
    std::uint64_t stream = 0;
    std::string hand;
  };

  /// A timed sample of the session has come. Nothing if it does not count: no server, a session
  /// that is closed or not known, or one that began to stream before the one followed.
  std::optional<Heard> hear(std::uint64_t session, std::int64_t stamp_ns);

  /// What a server said before it went is forgotten: what comes later is news.
  void serverIsThere(bool is_there);

  /// The newest pose, once. `server_ns`: SolutionFollower::take.
  std::optional<Pose> take(std::optional<std::int64_t> server_ns, Time now);

  /// The stream whose newest pose still stands; nothing when none does.
  [[nodiscard]] std::optional<std::uint64_t> alive(Time now) const;

  /// It followed a demonstrator, who has fallen silent.
  [[nodiscard]] bool isLeft(Time now) const;

  /// The session followed; 0: none yet.
  [[nodiscard]] std::uint64_t session() const { return session_; }

 private:
  SolutionFollower follower_;
  bool outlives_closing_;
  std::string hand_;
  bool server_is_there_ = false;
  bool has_begun_ = false;  // the stream, in this server's life
  std::uint64_t stream_ = 0;
  std::uint64_t session_ = 0;
  std::uint64_t last_sequence_ = 0;
  std::vector<double> last_joint_rad_;
  std::optional<Time> live_at_;  ///< when a demonstrator's frame was answered last
};

}  // namespace handgraft::bridge
