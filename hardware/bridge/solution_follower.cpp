#include "hardware/bridge/solution_follower.h"

#include <algorithm>
#include <tuple>

namespace handgraft::bridge {

namespace {

constexpr std::size_t kMostSessions =
    256;  // remembered, the latest: a server may hold more open
// A pose is written within milliseconds of its stamp, also by a server that starves; those out
// of a store are older.
constexpr std::int64_t kKeptAfter = 3'000'000'000;  // ns
constexpr std::int64_t kSilence = 1'000'000'000;    // ns
constexpr std::int64_t kLiveFor = 1'000'000'000;    // ns

}  // namespace

SolutionFollower::SolutionFollower(std::optional<std::uint64_t> only, bool with_intermediate)
    : only_(only), with_intermediate_(with_intermediate) {}

SolutionFollower::Session& SolutionFollower::sessionOf(std::uint64_t id) {
  const bool is_new = sessions_.find(id) == sessions_.end();
  if (is_new && sessions_.size() >= kMostSessions) {
    // Full: the one heard of longest ago makes room, but never the one followed.
    const auto older = [this](const auto& a, const auto& b) {
      return std::make_tuple(a.first == followed_, a.second.last_seen) <
             std::make_tuple(b.first == followed_, b.second.last_seen);
    };
    sessions_.erase(std::min_element(sessions_.begin(), sessions_.end(), older));
  }
  Session& session = sessions_[id];
  session.last_seen = ++seen_count_;
  return session;
}

bool SolutionFollower::beganAfter(std::uint64_t a, std::uint64_t b) const {
  return std::make_pair(sessions_.at(a).first_stamp, a) >
         std::make_pair(sessions_.at(b).first_stamp, b);
}

void SolutionFollower::see(const v1::SessionState& state) {
  if (state.session_id() == 0 || (only_ && state.session_id() != *only_)) return;
  Session& session = sessionOf(state.session_id());
  const bool is_anew =
      session.is_left || (session.state && (state.hand() != session.state->hand() ||
                                            state.revision() < session.state->revision()));
  if (is_anew) session.hand_since = state.revision();
  session.is_left = false;
  const bool closes = state.phase() == v1::PHASE_CLOSED;
  session.is_history = closes && (!session.state || session.is_history);
  session.is_closed = closes;
  session.state = state;
}

bool SolutionFollower::leave(const v1::SessionState& state) {
  const std::uint64_t id = state.session_id();
  if (id == 0 || (only_ && id != *only_)) return false;
  Session& session = sessionOf(id);
  session.is_left = true;
  session.state.reset();
  if (awaited_ == id) awaited_ = 0;
  if (followed_ != id) return false;
  followed_ = 0;
  return true;
}

// A newest pose of the state's own hand.
bool SolutionFollower::hasPose(const Session& session) {
  return session.newest && session.state && !session.is_history &&
         session.newest->revision() >= session.hand_since &&
         session.newest->revision() <= session.state->revision();
}

void SolutionFollower::see(const v1::PoseSolution& solution, std::int64_t written_ns) {
  const std::uint64_t id = solution.session_id();
  if (id == 0 || (only_ && id != *only_)) return;
  if (!solution.is_final() && !with_intermediate_) return;
  Session& session = sessionOf(id);
  const bool is_kept = written_ns > kKeptAfter && solution.stamp_ns() < written_ns - kKeptAfter;
  session.is_kept = is_kept && !only_ && id != awaited_ && id != followed_;
  if (session.is_kept) return;
  // Of a session taken up again, it is the sending that is news.
  const std::int64_t stamp_ns = is_kept ? written_ns : solution.stamp_ns();
  const bool is_repeat = session.has_streamed &&
                         solution.sequence_number() <= session.last_number &&
                         stamp_ns <= session.last_stamp;
  if (is_repeat) return;
  const bool is_live = !solution.time_s().empty();
  if (!session.has_streamed || (is_live && stamp_ns - session.live_ns > kSilence))
    session.first_stamp = stamp_ns;
  if (is_live) session.live_ns = stamp_ns;
  session.has_streamed = true;
  session.last_number = solution.sequence_number();
  session.last_stamp = stamp_ns;
  session.newest = solution;
  session.newest->stamp_ns(stamp_ns);
  session.written_ns = written_ns != 0 ? written_ns : stamp_ns;
}

std::optional<std::uint64_t> SolutionFollower::takeKept() {
  return takeTold(&Session::is_kept);
}

std::optional<std::uint64_t> SolutionFollower::takeLeft() {
  return takeTold(&Session::is_left_by_demonstrator);
}

std::optional<std::uint64_t> SolutionFollower::takeBeside() {
  return takeTold(&Session::is_beside);
}

std::optional<std::uint64_t> SolutionFollower::takeTold(bool Session::*is_to_be_told) {
  for (auto& [id, session] : sessions_) {
    if (!(session.*is_to_be_told) || !session.state || session.is_closed) continue;
    session.*is_to_be_told = false;
    return id;
  }
  return std::nullopt;
}

// It answers a demonstrator's frame.
bool SolutionFollower::isLive(const Session& session) {
  return session.newest && !session.newest->time_s().empty();
}

void SolutionFollower::passOverLeft(std::int64_t server_ns) {
  for (auto& [id, session] : sessions_) {
    if (!isLive(session) || server_ns - session.written_ns <= kLiveFor) continue;
    session.newest.reset();
    session.is_left_by_demonstrator = true;
  }
}

const std::string* SolutionFollower::hear(std::uint64_t id, std::int64_t stamp_ns) {
  if (id == 0 || (only_ && id != *only_)) return nullptr;
  Session& session = sessionOf(id);
  if (!session.state || session.is_closed || session.is_history) return nullptr;
  if (!session.has_streamed || stamp_ns - session.heard_ns > kSilence)
    session.first_stamp = stamp_ns;
  session.heard_ns = stamp_ns;
  session.has_streamed = true;
  if (followed_ != id) {
    const auto current = sessions_.find(followed_);
    const bool is_free = current == sessions_.end() || current->second.is_closed;
    if (!mayFollow(id) || (!is_free && !beganAfter(id, followed_))) return nullptr;
    followed_ = id;
  }
  return &session.state->hand();
}

void SolutionFollower::forget() {
  if (followed_ != 0) awaited_ = followed_;
  for (const auto& [id, session] : sessions_)
    if (of_before_.size() < kMostSessions) of_before_.insert(id);
  sessions_.clear();
  followed_ = 0;
}

bool SolutionFollower::mayFollow(std::uint64_t id) const {
  if (awaited_ == 0 || id == awaited_ || !of_before_.contains(id)) return true;
  const auto current = sessions_.find(followed_ != 0 ? followed_ : awaited_);
  return current != sessions_.end() && current->second.is_closed;
}

bool SolutionFollower::isClosed() const {
  const auto found = sessions_.find(followed_);
  return found != sessions_.end() && found->second.is_closed;
}

std::optional<FollowedPose> SolutionFollower::take(std::optional<std::int64_t> server_ns) {
  if (server_ns) passOverLeft(*server_ns);
  // Only sessions with something new can take over; the one followed stays until then.
  for (const auto& [id, session] : sessions_) {
    if (!hasPose(session) || !mayFollow(id) || (isLive(session) && !server_ns)) continue;
    const auto current = sessions_.find(followed_);
    const bool is_free = current == sessions_.end() || current->second.is_closed;
    if (is_free || beganAfter(id, followed_)) followed_ = id;
  }
  // What was passed over is not kept for later: a session taken up again starts with a new
  // pose.
  for (auto& [id, session] : sessions_) {
    if (followed_ == 0 || id == followed_ || !session.state) continue;
    session.is_beside = session.is_beside || (hasPose(session) && !session.is_closed);
    session.newest.reset();
  }
  const auto found = sessions_.find(followed_);
  if (found == sessions_.end()) return std::nullopt;
  Session& session = found->second;
  if (!hasPose(session) || (isLive(session) && !server_ns)) return std::nullopt;

  FollowedPose pose;
  pose.is_live = isLive(session);
  pose.session_id = followed_;
  pose.sequence_number = session.newest->sequence_number();
  pose.stamp_ns = session.newest->stamp_ns();
  pose.hand = session.state->hand();
  pose.names = session.state->joint_names();
  pose.joint_rad = session.newest->joint_positions();
  session.newest.reset();
  return pose;
}

}  // namespace handgraft::bridge
