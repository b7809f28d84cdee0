#include "hardware/bridge/motion_thread.h"

#include <utility>

namespace handgraft::bridge {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds kEndPatience(1);  // beyond the braking time

}  // namespace

MotionThread::MotionThread(std::unique_ptr<Motion> motion,
                           std::atomic<bool>& estop_flag,
                           std::shared_ptr<WakeEvent> bell)
    : motion_(std::move(motion)),
      config_(motion_->config()),
      estop_flag_(estop_flag),
      bell_(std::move(bell)),
      samples_(config_.jointCount()),
      states_(motion_->state()),
      thread_([this] {
        run();
      }) {}

MotionThread::~MotionThread() {
  is_ending_ = true;
  thread_.join();
}

void MotionThread::offer(StreamPose pose) {
  poses_.draft() = std::move(pose);
  poses_.publish();
}

void MotionThread::renew(std::uint64_t stream, safety::Time time) {
  renewals_.draft() = {stream, time};
  renewals_.publish();
}

void MotionThread::turn(Periodic& periodic) {
  // A stop does not wait for anything.
  if (estop_flag_.exchange(false)) motion_->estop();
  if (const StreamPose* pose = poses_.take()) motion_->offer(*pose);
  while (const TimedPose* sample = samples_.front()) {
    motion_->offer(*sample);
    samples_.drop();
  }
  if (const Renewal* renewal = renewals_.take()) motion_->renew(renewal->stream, renewal->time);
  while (const std::optional<Request> request = requests_.take())
    motion_->request(*request);
  if (wants_disarm_.exchange(false)) motion_->request(Request::kDisarm);
  motion_->turn();
  if (motion_->wasSlow()) periodic.forgive();
  MotionState& told = states_.draft();
  told = motion_->state();
  told.periods = periodic.periods();
  told.overruns = periodic.overruns();
  told.worst_lateness = periodic.worstLateness();
  told.is_realtime = is_realtime_;
  states_.publish();
  bell_->ring();
}

void MotionThread::run() {
  const int priority = config_.realtime_priority;
  is_realtime_ = priority > 0 && becomeRealtime(priority);
  Periodic periodic(std::chrono::duration_cast<Clock::duration>(
      std::chrono::duration<double>(config_.governor.period_s)));
  std::optional<Clock::time_point> give_up;
  while (true) {
    const Clock::time_point now = Clock::now();
    const Clock::time_point due = periodic.begin(now);
    if (is_ending_ && !give_up) {
      give_up = now + config_.governor.brake_within + kEndPatience;
      motion_->request(Request::kDisarm);
    }
    turn(periodic);
    if (give_up && (!motion_->state().is_powered || now >= *give_up)) break;
    sleepUntil(due);
  }
  motion_->switchOff();
}

}  // namespace handgraft::bridge
