#pragma once

#include <atomic>
#include <memory>
#include <thread>

#include "hardware/bridge/motion.h"
#include "hardware/bridge/periodic.h"
#include "hardware/bridge/request_ring.h"
#include "hardware/bridge/triple_buffer.h"
#include "hardware/bridge/wake_event.h"

namespace handgraft::bridge {

/// Runs a Motion on a thread of its own, once a period by absolute deadlines, real-time where
/// its config asks for that and the system permits it. All that goes in and out is handed over
/// without locks: the newest pose wins, requests keep their order, an emergency stop is a flag.
///
/// Threads: `offer`, `renew`, `request`, `take`, `last` and the end from one thread; `estop`
/// from any, also from a signal handler by way of the flag given to the constructor.
class MotionThread {
 public:
  /// `estop_flag` has to live as long as this: whenever it is found set, it is cleared and the
  /// hand stopped. A device that watches the same flag is stopped also while it is switched on.
  /// `bell` rings after each period. Errors: as of Motion.
  MotionThread(std::unique_ptr<Motion> motion,
               std::atomic<bool>& estop_flag,
               std::shared_ptr<WakeEvent> bell);
  /// Brakes, switches the motors off and ends; takes up to the braking time and 1 s.
  ~MotionThread();
  MotionThread(const MotionThread&) = delete;
  MotionThread& operator=(const MotionThread&) = delete;

  void offer(StreamPose pose);

  /// Of the stream that was offered last, in the order of the config's joints.
  void offer(const TimedPose& sample) { static_cast<void>(samples_.put(sample)); }

  /// `stream` lived at `time`.
  void renew(std::uint64_t stream, safety::Time time);

  /// Of a flood all but a disarming may be lost.
  void request(Request request) {
    if (!requests_.put(request) && request == Request::kDisarm) wants_disarm_ = true;
  }

  void estop() { estop_flag_ = true; }

  /// The newest state, if there was a period since it was last taken.
  const MotionState* take() { return states_.take(); }

  [[nodiscard]] const MotionState& last() const { return states_.last(); }

  /// Of the config that it was made with; homing changes zeros alone.
  [[nodiscard]] const config::HandConfig& config() const { return config_; }

 private:
  struct Renewal {
    std::uint64_t stream = 0;
    safety::Time time{};
  };

  void run();
  void turn(Periodic& periodic);

  std::unique_ptr<Motion> motion_;
  config::HandConfig config_;
  std::atomic<bool>& estop_flag_;
  const std::shared_ptr<WakeEvent> bell_;
  std::atomic<bool> is_ending_{false};
  bool is_realtime_ = false;
  RequestRing requests_;
  std::atomic<bool> wants_disarm_{false};  // which the ring had no room for
  TripleBuffer<StreamPose> poses_;
  TimedPoseRing samples_;
  TripleBuffer<Renewal> renewals_;
  TripleBuffer<MotionState> states_;
  std::thread thread_;
};

}  // namespace handgraft::bridge
