#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "core/base/progress.h"
#include "idl/sessions.h"

namespace handgraft::server {

struct UndiagnosedPose;  // handlers/optimize.h

/// Where a session stands between an edit and its diagnosed pose.
enum class SolveStage {
  kResting,      ///< nothing is to be done
  kPending,      ///< edits were applied; their solve waits on the strand
  kSolving,      ///< for an edit or a request
  kUndiagnosed,  ///< the pose is out; its diagnosis waits
  kDiagnosing,
};

/// How a solve or a diagnosis ended.
enum class SolveEnd {
  kDone,
  kCutShort,   ///< for the sake of an edit: nothing was taken
  kStopped,    ///< by somebody, or its time was over
  kCancelled,  ///< who asked for it wants it no more, or the session is closed
};

/// For logs.
const char* nameOf(SolveEnd end);

/// When an edit may cut a solve short.
enum class Preemption {
  kNone,       ///< at once: a diagnosis
  kAnswer,     ///< once it had its time, so that a stream of edits sees answers
  kUnhurried,  ///< never: what needs no search
};

/// What becomes of a session's edits and requests on their way to a pose: what is asked for,
/// runs, is cut short, stopped, and out. It computes nothing and publishes nothing.
///
/// Threads: what is said to belong to the strand, from the session's tasks alone; the rest from
/// any thread.
class SolveCycle {
 public:
  using Clock = std::chrono::steady_clock;
  using Now = std::function<Clock::time_point()>;

  /// A moment among the stops: a stop ends what was asked for before it.
  enum class StopEpoch : std::uint64_t {};

  class Run;

  explicit SolveCycle(Now now = Clock::now) : now_(std::move(now)) {}

  SolveCycle(const SolveCycle&) = delete;
  SolveCycle& operator=(const SolveCycle&) = delete;

  /// Of the strand.
  [[nodiscard]] SolveStage stage() const;

  // === Edits that wait

  /// An edit was put on the strand; what runs is cut short for it, but has its time first: else
  /// a stream of edits would never see an answer.
  void editQueued();
  /// It is being applied, or was not taken.
  void editTaken();

  [[nodiscard]] int editsQueued() const { return edits_queued_; }

  // === Stopping

  /// Of what is asked for now.
  [[nodiscard]] StopEpoch asked() const;

  /// Stops what runs and what was asked for and has not begun, whoever asked for it: also by
  /// edits, which stay.
  void stop(const v1::ClientId& stopper);
  /// Likewise, where what runs has taken longer than that.
  void stopLongerThan(std::chrono::duration<double> longest);

  /// "stopped by client ab12cd34", or that its time was over: the last time.
  [[nodiscard]] std::string whoStopped() const;

  // === Of the strand

  /// What runs next was asked for then.
  void workFor(StopEpoch asked) { working_for_ = asked; }

  /// An edit was applied: the pose that is out is none of its, and a solve has to follow. True
  /// if none was on its way: it is to be put on the strand.
  [[nodiscard]] bool editApplied(StopEpoch asked);
  /// The solve that an edit cut short is put on the strand again, behind that edit: refused, it
  /// answers nothing. True as above.
  [[nodiscard]] bool solveAgain();
  /// It has its turn.
  void takePending();

  /// A request that an edit cut short waits for what becomes of that edit.
  void requestWaits() { ++requests_waiting_; }

  void requestGoesOn() { --requests_waiting_; }

  /// Something on the strand will come to a pose, and tell of it.
  [[nodiscard]] bool isAwaited() const { return is_pending_ || requests_waiting_ > 0; }

  /// Runs `step(run)` as what edits may cut short and anybody may stop; not at all where
  /// somebody stopped what it answers before it began. Cancelled becomes an end; what else
  /// `step` throws passes through. Reports go to `whole`, and its wish to stop is heard.
  SolveEnd run(const Progress& whole,
               Preemption patience,
               const std::function<void(Run&)>& step);

  /// A pose is out, of the session at `revision`, and is to be diagnosed; a stop of what it
  /// answers ends that, too.
  void poseOut(unsigned long long revision, std::shared_ptr<UndiagnosedPose> pose);

  /// It is diagnosed, or is not going to be.
  void forgetUndiagnosed() { undiagnosed_ = nullptr; }

  /// Null: none is out as the session stands, or it is diagnosed.
  [[nodiscard]] const std::shared_ptr<UndiagnosedPose>& undiagnosed() const {
    return undiagnosed_;
  }

  /// A pose came out at any time, so that few starts do for the next one.
  [[nodiscard]] bool wasSolved() const { return solved_revision_.has_value(); }

  /// The pose that was out last is of that revision.
  [[nodiscard]] bool isSolvedAt(unsigned long long revision) const {
    return solved_revision_ == revision;
  }

 private:
  [[nodiscard]] std::chrono::nanoseconds timeOf(Preemption patience) const;
  /// `mutex_` held.
  void stopRunning(std::optional<v1::ClientId> stopper);

  const Now now_;
  std::atomic<int> edits_queued_{0};

  mutable std::mutex mutex_;
  Run* running_ = nullptr;
  std::uint64_t stops_ = 0;
  std::optional<v1::ClientId> stopper_;  ///< the last one; nothing: its time was over

  // Of the strand.
  StopEpoch working_for_{};
  StopEpoch pending_for_{};  ///< as of the last edit that the solve answers
  bool is_pending_ = false;
  int requests_waiting_ = 0;
  int cut_short_ = 0;  ///< one after another, since the last that ended by itself
  std::shared_ptr<UndiagnosedPose> undiagnosed_;
  StopEpoch undiagnosed_for_{};  ///< what it answers was asked for then
  std::optional<unsigned long long> solved_revision_;
};

/// A solve or a diagnosis while it runs.
class SolveCycle::Run {
 public:
  Run(const Run&) = delete;
  Run& operator=(const Run&) = delete;

  /// Of this run: cancelled where it ends before its end.
  [[nodiscard]] const Progress& progress() const { return progress_; }

  /// Ends it if an edit waits and it had its time. From solving threads.
  void cancelForEdits();

 private:
  friend class SolveCycle;
  Run(SolveCycle& cycle, const Progress& whole, Preemption patience);
  ~Run();

  SolveCycle& cycle_;
  Progress progress_;
  const Preemption patience_;
  const std::chrono::nanoseconds time_;  ///< that it has before edits cut it short
  const Clock::time_point begin_;
  std::atomic<bool> is_cut_short_{false};
  std::atomic<bool> is_stopped_{false};
};

/// The first bytes of a client's id, enough to tell it from others.
std::string shortName(const v1::ClientId& client);

}  // namespace handgraft::server
