#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "hardware/bridge/inbox.h"
#include "hardware/bridge/timed_pose_ring.h"
#include "hardware/bridge/wake_event.h"
#include "idl/cyclone/participant.h"
#include "idl/cyclone/written_topics.h"
#include "idl/ros2.h"
#include "idl/sessions.h"

namespace handgraft::bridge {

/// The poses of one message, in the order of its points, each with its time on the sender's
/// clock: the header's stamp and `time_from_start`; a stamp of 0 is `system_ns`, as in ROS.
/// `names`: of the hand's joints, in the order of the poses. `stream` and `arrived` are left as
/// they are. A refusal in words instead, for joints that are not the hand's, no points or too
/// many, or a point with another number of positions.
struct ReadTrajectory {
  std::vector<TimedPose> poses;
  std::string refusal;
};

ReadTrajectory readTrajectory(const trajectory_msgs::msg::dds_::JointTrajectory_& message,
                              const std::vector<std::string>& names,
                              std::int64_t system_ns);

/// Timed samples of all sessions that are open: `rt/handgraft/<session>/joint_trajectory`. What
/// nobody writes is not read. Of a session that two programs play, the samples of the one that
/// came first count, until it has been silent for 250 ms: between two a hand would shake.
class TrajectoryFeed {
 public:
  using Message = trajectory_msgs::msg::dds_::JointTrajectory_;
  using Use = std::function<void(std::uint64_t session, const Message&)>;

  /// `bell` rings when a sample has come.
  TrajectoryFeed(const idl::cyclone::Participant& participant, std::shared_ptr<WakeEvent> bell);

  /// Listens to a session's samples once somebody writes some, until it is closed; to 32 at
  /// most: then others wait until one of them is written no more.
  void see(const v1::SessionState& session);

  /// Hands over what came, session by session. Errors: as of `use`.
  void take(std::chrono::steady_clock::time_point now, const Use& use);

  /// A session that two programs play; once while both do.
  std::optional<std::uint64_t> takeOther();

 private:
  struct Listener {
    std::string topic;
    std::unique_ptr<Inbox<Message>> reader;
    std::uint64_t player = 0;  ///< whose samples count; 0: nobody's yet
    std::chrono::steady_clock::time_point heard{};
    std::uint64_t other = 0;  ///< who was passed over last
    bool is_other_told = true;
  };

  static bool counts(Listener& listener,
                     std::uint64_t writer,
                     std::chrono::steady_clock::time_point now);

  void listenToWritten();

  idl::cyclone::Participant participant_;
  std::set<std::uint64_t> open_;
  std::shared_ptr<std::atomic<bool>> has_news_ = std::make_shared<std::atomic<bool>>(true);
  idl::cyclone::WrittenTopics written_;
  std::map<std::uint64_t, Listener> listeners_;
  std::shared_ptr<WakeEvent> bell_;
};

}  // namespace handgraft::bridge
