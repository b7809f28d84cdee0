#include "server/sessions/solve_cycle.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

namespace handgraft::server {

namespace {

// Before an edit cuts a solve short: most end by themselves then. Twice as long after each that
// was cut short, so that one ends some time.
constexpr std::chrono::milliseconds kLeastSolve(8);
constexpr int kMostDoublings = 12;
// Where the edits were applied, the next has no more time than people hardly notice.
constexpr int kMostDoublingsForEdits = 4;

}  // namespace

std::string shortName(const v1::ClientId& client) {
  return fmt::format("{:02x}{:02x}{:02x}{:02x}", client[0], client[1], client[2], client[3]);
}

const char* nameOf(SolveEnd end) {
  switch (end) {
    case SolveEnd::kDone:
      return "done";
    case SolveEnd::kCutShort:
      return "cut_short";
    case SolveEnd::kStopped:
      return "stopped";
    case SolveEnd::kCancelled:
      return "cancelled";
  }
  return "";
}

SolveStage SolveCycle::stage() const {
  {
    const std::lock_guard lock(mutex_);
    if (running_ != nullptr) {
      return running_->patience_ == Preemption::kNone ? SolveStage::kDiagnosing
                                                      : SolveStage::kSolving;
    }
  }
  if (is_pending_) return SolveStage::kPending;
  return undiagnosed_ ? SolveStage::kUndiagnosed : SolveStage::kResting;
}

// === Edits that wait

void SolveCycle::editQueued() {
  ++edits_queued_;
  const std::lock_guard lock(mutex_);
  if (running_ != nullptr) running_->cancelForEdits();
}

void SolveCycle::editTaken() {
  --edits_queued_;
}

bool SolveCycle::editApplied(StopEpoch asked) {
  // Where the machine is so busy that one edit's solve after the other is cut short, the next
  // gets more time, within bounds.
  cut_short_ = std::min(cut_short_, kMostDoublingsForEdits);
  undiagnosed_ = nullptr;
  pending_for_ = asked;
  return solveAgain();
}

bool SolveCycle::solveAgain() {
  return !std::exchange(is_pending_, true);
}

void SolveCycle::takePending() {
  is_pending_ = false;
  working_for_ = pending_for_;
}

// === Stopping

SolveCycle::StopEpoch SolveCycle::asked() const {
  const std::lock_guard lock(mutex_);
  return StopEpoch{stops_};
}

void SolveCycle::stop(const v1::ClientId& stopper) {
  const std::lock_guard lock(mutex_);
  stopRunning(stopper);
}

void SolveCycle::stopLongerThan(std::chrono::duration<double> longest) {
  const std::lock_guard lock(mutex_);
  if (running_ == nullptr || running_->is_stopped_) return;
  if (now_() - running_->begin_ > longest) stopRunning(std::nullopt);
}

void SolveCycle::stopRunning(std::optional<v1::ClientId> stopper) {
  ++stops_;
  stopper_ = stopper;
  if (running_ == nullptr) return;
  running_->is_stopped_ = true;
  running_->progress_.cancel();
}

std::string SolveCycle::whoStopped() const {
  const std::lock_guard lock(mutex_);
  return stopper_ ? "stopped by client " + shortName(*stopper_) : "stopped: its time is over";
}

// === Running

std::chrono::nanoseconds SolveCycle::timeOf(Preemption patience) const {
  switch (patience) {
    case Preemption::kNone:
      return std::chrono::nanoseconds(0);
    case Preemption::kAnswer:
      return kLeastSolve * (1 << std::min(cut_short_, kMostDoublings));
    case Preemption::kUnhurried:
      break;
  }
  return std::chrono::nanoseconds::max();
}

SolveEnd SolveCycle::run(const Progress& whole,
                         Preemption patience,
                         const std::function<void(Run&)>& step) {
  Run run(*this, whole, patience);
  if (run.is_stopped_) return SolveEnd::kStopped;
  run.cancelForEdits();  // to one that came before
  try {
    step(run);
  } catch (const Cancelled&) {
    if (run.is_stopped_) return SolveEnd::kStopped;
    if (!run.is_cut_short_) return SolveEnd::kCancelled;
    if (patience == Preemption::kAnswer) ++cut_short_;
    return SolveEnd::kCutShort;
  }
  if (patience == Preemption::kAnswer) cut_short_ = 0;
  return SolveEnd::kDone;
}

void SolveCycle::poseOut(unsigned long long revision, std::shared_ptr<UndiagnosedPose> pose) {
  solved_revision_ = revision;
  undiagnosed_ = std::move(pose);
  undiagnosed_for_ = working_for_;
}

SolveCycle::Run::Run(SolveCycle& cycle, const Progress& whole, Preemption patience)
    : cycle_(cycle),
      progress_(whole,
                [this, &whole](std::string_view stage, double fraction) {
                  cancelForEdits();
                  whole.report(stage, fraction);
                }),
      patience_(patience),
      time_(cycle.timeOf(patience)),
      begin_(cycle.now_()) {
  const std::lock_guard lock(cycle_.mutex_);
  cycle_.running_ = this;
  const bool diagnoses = patience == Preemption::kNone;
  if (StopEpoch{cycle_.stops_} == (diagnoses ? cycle_.undiagnosed_for_ : cycle_.working_for_))
    return;
  is_stopped_ = true;
  progress_.cancel();
}

SolveCycle::Run::~Run() {
  const std::lock_guard lock(cycle_.mutex_);
  cycle_.running_ = nullptr;
}

void SolveCycle::Run::cancelForEdits() {
  if (cycle_.edits_queued_ == 0 || is_cut_short_) return;
  if (cycle_.now_() - begin_ < time_) return;
  is_cut_short_ = true;
  progress_.cancel();
}

}  // namespace handgraft::server
