#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "idl/sessions.h"

namespace handgraft::bridge {

/// A pose that a session asks the hand to take, with all that is needed to read it.
struct FollowedPose {
  std::uint64_t session_id = 0;
  std::uint64_t sequence_number = 0;
  std::int64_t stamp_ns = 0;       ///< the server's clock
  std::string hand;                ///< the model's name
  std::vector<std::string> names;  ///< the order of `joint_rad`
  std::vector<double> joint_rad;   ///< as it came: unchecked
  bool is_live = false;            ///< answers a demonstrator's frame, and counts no longer
};

/// Picks one session out of all that stream, and its newest pose. Solutions and session states
/// come on two topics, in any order; a pose waits for its session's state, newer poses replace
/// it.
///
/// Without a session given it follows the one that began to stream last, and another one when
/// that is closed and the other streams again. Poses that are not final are passed over unless
/// asked for. A pose counts as new if its sequence number or its stamp has grown, so a server
/// that starts anew may count from one again. Sessions that were already closed when first seen
/// are never followed: their last pose is history.
///
/// A server that comes back streams again what it kept, in whatever order. The session that was
/// followed before is followed again; the others of before wait until that one is closed, as
/// they would have without the gap. New ones take over as ever.
///
/// What a server took out of its store, nobody asks for now: a pose that was written long after
/// its own stamp counts only of the session given, or the one that was followed before. Others
/// begin to stream when somebody edits, solves or plays them.
///
/// Timed samples, and poses that answer a demonstrator, that come after a silence of a second
/// begin to stream then: whoever plays a session, or is followed there, means it.
///
/// A pose that answers a demonstrator's frame is worth something while it is fresh: one that
/// was written more than a second ago says where somebody was who has gone, and is passed over,
/// also of the session given.
///
/// A session may take another hand by an edit. Its poses count only with the state that says
/// whose they are: not before the state has come to their revision, and not if they answer a
/// revision before the one that brought this hand.
class SolutionFollower {
 public:
  SolutionFollower(std::optional<std::uint64_t> only, bool with_intermediate);

  void see(const v1::SessionState& state);
  /// `written_ns`: when it was sent, by the clock of its stamp; 0: as it was stamped.
  void see(const v1::PoseSolution& solution, std::int64_t written_ns = 0);

  /// An open session of which a pose out of a store was passed over; each is told once.
  std::optional<std::uint64_t> takeKept();

  /// The same of one that stands where its demonstrator left it.
  std::optional<std::uint64_t> takeLeft();

  /// An open session that streams, too, and began to before the one followed; told as often as
  /// it does.
  std::optional<std::uint64_t> takeBeside();

  /// Timed samples of this session come, first at `stamp_ns`: they count as its stream, beside
  /// its poses. The hand's name if it is the session followed, now or from now on; null if its
  /// state is not known yet, it is closed, or another session goes before.
  const std::string* hear(std::uint64_t id, std::int64_t stamp_ns);

  /// `state` says that its session is of a hand that is not ours. Its poses count no more,
  /// until a state of ours is seen; nor do those that answered the other hand. True if it was
  /// the one followed: none is then.
  bool leave(const v1::SessionState& state);

  /// The server is gone, and what it says when it is back is news.
  void forget();

  /// The newest pose of the followed session, once. `server_ns`: now, by the clock of what was
  /// written; while it is not known, poses that answer a demonstrator wait.
  std::optional<FollowedPose> take(std::optional<std::int64_t> server_ns);

  /// The session followed; 0: none yet.
  [[nodiscard]] std::uint64_t session() const { return followed_; }

  /// Whether the session followed has been closed; false without one.
  [[nodiscard]] bool isClosed() const;

 private:
  struct Session {
    std::optional<v1::SessionState> state;
    std::optional<v1::PoseSolution> newest;  // not yet taken
    bool has_streamed = false;
    std::int64_t first_stamp = 0;
    std::int64_t last_stamp = 0;
    std::int64_t written_ns = 0;  // the newest pose
    std::int64_t heard_ns = 0;    // the newest timed sample
    std::int64_t live_ns = 0;     // the newest answer to a demonstrator
    std::uint64_t last_number = 0;
    std::uint64_t hand_since = 0;  // the first revision known to be of this hand
    bool is_left = false;          // it was of another hand when last heard of
    bool is_closed = false;
    bool is_kept = false;  // it stands as a store kept it, and that is not told yet
    bool is_left_by_demonstrator = false;  // likewise
    bool is_beside = false;                // it streams, and another one is followed
    bool is_history = false;               // closed before we ever saw it open
    std::uint64_t last_seen = 0;
  };

  Session& sessionOf(std::uint64_t id);
  static bool hasPose(const Session& session);
  static bool isLive(const Session& session);
  std::optional<std::uint64_t> takeTold(bool Session::*is_to_be_told);
  void passOverLeft(std::int64_t server_ns);
  [[nodiscard]] bool beganAfter(std::uint64_t a, std::uint64_t b) const;
  [[nodiscard]] bool mayFollow(std::uint64_t id) const;

  std::optional<std::uint64_t> only_;
  bool with_intermediate_;
  std::map<std::uint64_t, Session> sessions_;
  std::uint64_t followed_ = 0;
  std::uint64_t awaited_ = 0;          ///< followed before a gap; 0: none
  std::set<std::uint64_t> of_before_;  ///< all that were known before one
  std::uint64_t seen_count_ = 0;
};

}  // namespace handgraft::bridge
