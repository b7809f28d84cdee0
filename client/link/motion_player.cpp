#include "client/link/motion_player.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/error.h"
#include "idl/topics.h"

namespace handgraft::client {

namespace {

constexpr double kSlowest = 0.01;
constexpr double kGoOver = 0.5;  // s
constexpr double kFastest = 100.0;
constexpr std::size_t kLongestTopic = 255;

idl::Topic<trajectory_msgs::msg::dds_::JointTrajectory_> sampleTopic(const std::string& name) {
  if (name.empty() || name.size() > kLongestTopic)
    rejectInput("topic {}: a name has 1 to {} characters", handgraft::quoted(name),
                kLongestTopic);
  auto topic = idl::kRosSamplesTopic;
  topic.name = name.c_str();
  return topic;
}

}  // namespace

// === The clock

PlayClock::PlayClock(double duration_s) : duration_s_(duration_s) {
  if (!(duration_s >= 0.0) || !std::isfinite(duration_s))
    rejectInput("a motion of {} s cannot be played", duration_s);
}

double PlayClock::at(Time now) const {
  if (!plays_) return time_s_;
  const double passed_s = std::chrono::duration<double>(now - since_).count();
  const double time_s = time_s_ + speed_ * std::max(0.0, passed_s);
  if (time_s <= duration_s_) return time_s;
  return loops_ && duration_s_ > 0.0 ? std::fmod(time_s, duration_s_) : duration_s_;
}

bool PlayClock::isPlaying(Time now) const {
  return plays_ && (loops_ || at(now) < duration_s_);
}

void PlayClock::settle(Time now) {
  time_s_ = at(now);
  since_ = std::max(since_, now);
}

void PlayClock::play(Time now) {
  settle(now);
  if (!plays_ || !isPlaying(now)) {
    if (time_s_ >= duration_s_) time_s_ = 0.0;
  }
  plays_ = true;
}

void PlayClock::pause(Time now) {
  settle(now);
  plays_ = false;
}

void PlayClock::seek(double time_s, Time now) {
  if (!(time_s >= 0.0) || !(time_s <= duration_s_))
    rejectInput("seek to {} s: the motion goes from 0 to {} s", time_s, duration_s_);
  settle(now);
  time_s_ = time_s;
}

void PlayClock::setSpeed(double speed, Time now) {
  if (!(speed >= kSlowest) || !(speed <= kFastest))
    rejectInput("speed {}: it is {} to {} times real time", speed, kSlowest, kFastest);
  settle(now);
  speed_ = speed;
}

void PlayClock::setLooping(bool loops, Time now) {
  settle(now);
  loops_ = loops;
}

// === The way

JointInterpolation::JointInterpolation(const std::vector<v1::MotionFrame>& frames) {
  if (frames.empty()) rejectInput("a motion without frames cannot be played");
  for (const v1::MotionFrame& frame : frames) {
    const double time_s = frame.time_s() - frames.front().time_s();
    if (!std::isfinite(time_s) || (!time_s_.empty() && time_s <= time_s_.back()))
      rejectInput("frame {}: its time {} s does not lie behind the one before", frame.index(),
                  frame.time_s());
    if (frame.joint_positions().size() != frames.front().joint_positions().size())
      rejectInput("frame {}: {} joints; the first has {}", frame.index(),
                  frame.joint_positions().size(), frames.front().joint_positions().size());
    time_s_.push_back(time_s);
    joints_.push_back(frame.joint_positions());
  }
}

std::vector<double> JointInterpolation::at(double time_s) const {
  const auto above = std::upper_bound(time_s_.begin(), time_s_.end(), time_s);
  if (above == time_s_.begin()) return joints_.front();
  if (above == time_s_.end()) return joints_.back();
  const auto next = static_cast<std::size_t>(above - time_s_.begin());
  const double share = (time_s - time_s_[next - 1]) / (time_s_[next] - time_s_[next - 1]);
  std::vector<double> joints = joints_[next - 1];
  for (std::size_t i = 0; i < joints.size(); ++i)
    joints[i] += share * (joints_[next][i] - joints[i]);
  return joints;
}

bool ChangingWay::isChanging(Time now) const {
  return before_ && std::chrono::duration<double>(now - since_).count() < kGoOver;
}

void ChangingWay::goOverTo(JointInterpolation way, Time now) {
  HANDGRAFT_REQUIRE(!isChanging(now));
  if (way.duration() != now_.duration()) {
    rejectInput("the motion lasts {:g} s now, it was {:g} s: play it anew", way.duration(),
                now_.duration());
  }
  before_ = std::exchange(now_, std::move(way));
  since_ = now;
}

std::vector<double> ChangingWay::at(double time_s, Time now) const {
  std::vector<double> joints = now_.at(time_s);
  if (!before_) return joints;
  const double share =
      std::clamp(std::chrono::duration<double>(now - since_).count() / kGoOver, 0.0, 1.0);
  if (share == 1.0) return joints;
  const std::vector<double> before = before_->at(time_s);
  for (std::size_t i = 0; i < joints.size(); ++i)
    joints[i] = before[i] + share * (joints[i] - before[i]);
  return joints;
}

// === Samples

SampleWriter::SampleWriter(const idl::cyclone::Participant& participant,
                           const std::string& topic,
                           std::vector<std::string> joint_names)
    : topic_(topic), writer_(participant, sampleTopic(topic_)) {
  message_.joint_names(std::move(joint_names));
  message_.points().resize(1);  // to be reached at the stamp itself
}

void SampleWriter::write(const std::vector<double>& joints,
                         std::chrono::system_clock::time_point stamp) {
  const auto seconds = std::chrono::floor<std::chrono::seconds>(stamp);
  const std::chrono::nanoseconds rest = stamp - seconds;
  message_.header().stamp().sec(static_cast<std::int32_t>(seconds.time_since_epoch().count()));
  message_.header().stamp().nanosec(static_cast<std::uint32_t>(rest.count()));
  message_.points().front().positions(joints);
  writer_.write(message_);
}

}  // namespace handgraft::client
