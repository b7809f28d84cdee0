#include "hardware/bridge/trajectory_feed.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include <fmt/format.h>

#include "core/base/error.h"
#include "hardware/bridge/pose_refusal.h"
#include "hardware/bridge/sample_path.h"
#include "idl/topics.h"

namespace handgraft::bridge {

namespace {

constexpr std::size_t kMostListeners = 32;
constexpr std::size_t kMostSessions = 4096;
constexpr char kPrefix[] = "rt/handgraft/";  // of sampleTopicName
constexpr std::int64_t kSecondNs = 1'000'000'000;
constexpr std::chrono::milliseconds kPlayerSilence(250);

std::int64_t nanosecondsOf(std::int32_t sec, std::uint32_t nanosec) {
  return kSecondNs * sec + nanosec;
}

}  // namespace

ReadTrajectory readTrajectory(const trajectory_msgs::msg::dds_::JointTrajectory_& message,
                              const std::vector<std::string>& names,
                              std::int64_t system_ns) {
  const std::vector<std::string>& told = message.joint_names();
  std::vector<std::size_t> joint_of;
  for (const std::string& name : told) {
    const auto found = std::find(names.begin(), names.end(), name);
    if (found != names.end())
      joint_of.push_back(static_cast<std::size_t>(found - names.begin()));
  }
  std::vector<std::size_t> each = joint_of;
  std::sort(each.begin(), each.end());
  const bool has_all = told.size() == names.size() && each.size() == names.size() &&
                       std::adjacent_find(each.begin(), each.end()) == each.end();
  if (!has_all) {
    const FixedText why =
        describeRefusal(safety::SampleVerdict::kWrongNames, names, told, told.size());
    return {{}, std::string(why.view())};
  }
  if (message.points().empty() || message.points().size() > SamplePath::kMostSamples) {
    return {{},
            fmt::format("{} points in a message are not in [1, {}]", message.points().size(),
                        SamplePath::kMostSamples)};
  }
  std::int64_t start_ns =
      nanosecondsOf(message.header().stamp().sec(), message.header().stamp().nanosec());
  if (start_ns == 0) start_ns = system_ns;
  ReadTrajectory read;
  for (const auto& point : message.points()) {
    if (point.positions().size() != names.size()) {
      return {{},
              fmt::format("a point has {} positions for {} joints", point.positions().size(),
                          names.size())};
    }
    TimedPose pose;
    pose.source_ns = start_ns + nanosecondsOf(point.time_from_start().sec(),
                                              point.time_from_start().nanosec());
    pose.continues = !read.poses.empty();
    pose.joint_rad.resize(names.size());
    for (std::size_t i = 0; i < names.size(); ++i)
      pose.joint_rad[joint_of[i]] = point.positions()[i];
    read.poses.push_back(std::move(pose));
  }
  return read;
}

TrajectoryFeed::TrajectoryFeed(const idl::cyclone::Participant& participant,
                               std::shared_ptr<WakeEvent> bell)
    : participant_(participant),
      written_(participant,
               kPrefix,
               [has_news = has_news_, bell] {
                 *has_news = true;
                 bell->ring();
               }),
      bell_(std::move(bell)) {}

void TrajectoryFeed::see(const v1::SessionState& session) {
  const std::uint64_t id = session.session_id();
  if (session.phase() == v1::PHASE_CLOSED) {
    listeners_.erase(id);
    open_.erase(id);
    return;
  }
  if (id == 0 || !open_.insert(id).second) return;
  // Ids are random: whoever is forgotten is heard again once its session changes.
  if (open_.size() > kMostSessions)
    open_.erase(*open_.begin() == id ? std::prev(open_.end()) : open_.begin());
  *has_news_ = true;
}

void TrajectoryFeed::listenToWritten() {
  for (const std::uint64_t session : open_) {
    const std::string name = idl::sampleTopicName(session);
    if (listeners_.count(session) != 0 || !written_.contains(name)) continue;
    if (listeners_.size() >= kMostListeners) {
      std::erase_if(listeners_, [&](const auto& one) {
        return !written_.contains(one.second.topic);
      });
      if (listeners_.size() >= kMostListeners) return;
    }
    Listener& listener = listeners_[session];
    listener.topic = name;
    idl::Topic<Message> topic = idl::kRosSamplesTopic;
    topic.name = listener.topic.c_str();
    listener.reader = std::make_unique<Inbox<Message>>(participant_, topic, bell_);
  }
}

bool TrajectoryFeed::counts(Listener& listener,
                            std::uint64_t writer,
                            std::chrono::steady_clock::time_point now) {
  if (listener.player != writer && listener.player != 0 &&
      now - listener.heard <= kPlayerSilence) {
    if (listener.other != writer) listener.is_other_told = false;
    listener.other = writer;
    return false;
  }
  if (listener.player != writer) listener.other = 0;
  listener.player = writer;
  listener.heard = now;
  return true;
}

void TrajectoryFeed::take(std::chrono::steady_clock::time_point now, const Use& use) {
  if (has_news_->exchange(false)) listenToWritten();
  for (auto& [id, listener] : listeners_) {
    listener.reader->takeWithOrigin(
        [&, session = id, &from = listener](const Message& message,
                                            const idl::cyclone::Origin& origin) {
          if (counts(from, origin.writer, now)) use(session, message);
        });
  }
}

std::optional<std::uint64_t> TrajectoryFeed::takeOther() {
  for (auto& [id, listener] : listeners_) {
    if (listener.is_other_told) continue;
    listener.is_other_told = true;
    return id;
  }
  return std::nullopt;
}

}  // namespace handgraft::bridge
