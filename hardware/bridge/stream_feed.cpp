#include "hardware/bridge/stream_feed.h"

#include <utility>

namespace handgraft::bridge {

namespace {

constexpr std::chrono::milliseconds kLiveSilence(500);

}  // namespace

StreamFeed::StreamFeed(std::optional<std::uint64_t> only,
                       bool with_intermediate,
                       bool outlives_closing,
                       std::string hand)
    : follower_(only, with_intermediate),
      outlives_closing_(outlives_closing),
      hand_(std::move(hand)) {}

bool StreamFeed::see(const v1::SessionState& state) {
  if (!hand_.empty() && state.hand() != hand_) {
    if (follower_.leave(state)) has_begun_ = false;
    return false;
  }
  follower_.see(state);
  return true;
}

void StreamFeed::serverIsThere(bool is_there) {
  if (server_is_there_ && !is_there) {
    follower_.forget();
    has_begun_ = false;
  }
  server_is_there_ = is_there;
}

bool StreamFeed::isAnew(const v1::PoseSolution& solution) const {
  constexpr unsigned kPerLife = 32;
  return has_begun_ && solution.session_id() == session_ && last_sequence_ != 0 &&
         solution.sequence_number() >> kPerLife != last_sequence_ >> kPerLife;
}

std::optional<StreamFeed::Pose> StreamFeed::take(std::optional<std::int64_t> server_ns,
                                                 Time now) {
  std::optional<FollowedPose> pose = follower_.take(server_ns);
  if (!pose) return std::nullopt;
  live_at_.reset();
  if (pose->is_live) live_at_ = now;
  const bool goes_on =
      has_begun_ && pose->session_id == session_ && pose->sequence_number > last_sequence_;
  if (!goes_on) ++stream_;
  has_begun_ = true;
  session_ = pose->session_id;
  last_sequence_ = pose->sequence_number;
  const bool is_repeat = goes_on && pose->joint_rad == last_joint_rad_;
  last_joint_rad_ = pose->joint_rad;
  return Pose{stream_, is_repeat, std::move(*pose)};
}

std::optional<StreamFeed::Heard> StreamFeed::hear(std::uint64_t session,
                                                  std::int64_t stamp_ns) {
  if (!server_is_there_) return std::nullopt;
  const std::string* hand = follower_.hear(session, stamp_ns);
  if (hand == nullptr) return std::nullopt;
  if (!has_begun_ || session != session_) {
    ++stream_;
    last_sequence_ = 0;
    last_joint_rad_.clear();
  }
  has_begun_ = true;
  live_at_.reset();
  session_ = session;
  return Heard{stream_, *hand};
}

bool StreamFeed::isLeft(Time now) const {
  return has_begun_ && live_at_ && now - *live_at_ > kLiveSilence;
}

std::optional<std::uint64_t> StreamFeed::alive(Time now) const {
  if (!server_is_there_ || !has_begun_ || isLeft(now)) return std::nullopt;
  if (follower_.isClosed() && !outlives_closing_) return std::nullopt;
  return stream_;
}

}  // namespace handgraft::bridge
