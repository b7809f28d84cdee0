#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/network.h"
#include "idl/cyclone/participant.h"
#include "idl/motions.h"
#include "idl/ros2.h"

namespace handgraft::client {

/// The one clock of a motion that is played: from 0 to its duration, at a speed, once or again
/// and again. Time is whatever the caller's clock says, and has to rise.
class PlayClock {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// Stands at 0. Errors: InvalidInput if the duration is negative or not finite.
  explicit PlayClock(double duration_s);

  // === What may be asked of it at `now`

  /// From the end on it plays from the beginning. `now` may lie ahead of what is asked next:
  /// until then it stands where it is.
  void play(Time now);
  void pause(Time now);
  /// Errors: InvalidInput outside [0, duration].
  void seek(double time_s, Time now);
  /// Times real time. Errors: InvalidInput outside [0.01, 100].
  void setSpeed(double speed, Time now);
  void setLooping(bool loops, Time now);

  // === What it says

  [[nodiscard]] double at(Time now) const;
  /// False once it has come to the end, unless it loops.
  [[nodiscard]] bool isPlaying(Time now) const;

  [[nodiscard]] double speed() const { return speed_; }

  [[nodiscard]] bool isLooping() const { return loops_; }

  [[nodiscard]] double duration() const { return duration_s_; }

 private:
  void settle(Time now);

  double duration_s_;
  double speed_ = 1.0;
  bool loops_ = false;
  bool plays_ = false;
  double time_s_ = 0.0;  // at since_
  Time since_{};
};

/// The joints of a motion's frames over time, and between them.
class JointInterpolation {
 public:
  /// Times from the first frame on. Errors: InvalidInput without frames, if times do not rise,
  /// or frames differ in their joints.
  explicit JointInterpolation(const std::vector<v1::MotionFrame>& frames);

  [[nodiscard]] double duration() const { return time_s_.back(); }

  /// Linear between frames; the first or last one beyond them.
  [[nodiscard]] std::vector<double> at(double time_s) const;

 private:
  std::vector<double> time_s_;
  std::vector<std::vector<double>> joints_;
};

/// The way of a motion that is edited while it is played: another one takes over within half a
/// second.
class ChangingWay {
 public:
  using Time = PlayClock::Time;

  explicit ChangingWay(JointInterpolation way) : now_(std::move(way)) {}

  [[nodiscard]] double duration() const { return now_.duration(); }

  /// Another one is taking over. A third one has to wait for it: from between two it would
  /// jump.
  [[nodiscard]] bool isChanging(Time now) const;

  /// Errors: InvalidInput if its duration is another one; BrokenContract while it is changing.
  void goOverTo(JointInterpolation way, Time now);

  [[nodiscard]] std::vector<double> at(double time_s, Time now) const;

 private:
  JointInterpolation now_;
  std::optional<JointInterpolation> before_;
  Time since_{};
};

/// Writes timed samples for the hand of a session, as bridges and ROS 2 hear them.
class SampleWriter {
 public:
  /// `topic`: rt/handgraft/<session>/joint_trajectory, or another one.
  /// Errors: InvalidInput for a topic's name that is empty or too long; TransportError.
  SampleWriter(const idl::cyclone::Participant& participant,
               const std::string& topic,
               std::vector<std::string> joint_names);

  /// A pose for the system's time `stamp`.
  void write(const std::vector<double>& joints, std::chrono::system_clock::time_point stamp);

  /// How many listen.
  [[nodiscard]] int listeners() const { return writer_.readers(); }

  [[nodiscard]] const std::string& topic() const { return topic_; }

 private:
  std::string topic_;
  trajectory_msgs::msg::dds_::JointTrajectory_ message_;
  idl::cyclone::Writer<trajectory_msgs::msg::dds_::JointTrajectory_> writer_;
};

}  // namespace handgraft::client
