#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "core/base/progress.h"
#include "core/manipulation/motion.h"
#include "core/session/fit_check.h"
#include "core/session/live_follower.h"
#include "core/session/motion_bench.h"
#include "core/session/motion_solving.h"
#include "core/session/session.h"
#include "idl/motions.h"
#include "idl/sensor_msgs.h"
#include "idl/sessions.h"
#include "server/admission/strand_pool.h"
#include "server/sessions/session_journal.h"

namespace handgraft::server {

/// Who hears of the changes of sessions. Called from workers.
class SessionAudience {
 public:
  virtual ~SessionAudience() = default;
  virtual void onState(const v1::SessionState& state) = 0;
  virtual void onSolution(const v1::PoseSolution& solution) = 0;
  virtual void onJointCommand(std::uint64_t session_id,
                              const sensor_msgs::msg::dds_::JointState_& command) = 0;
  virtual void onMotionFrames(const v1::MotionFrames& frames) = 0;
  virtual void onClock(const v1::MotionClock& clock) = 0;
};

/// An edit that was applied, for those whose own edits came too late.
struct AppliedEdit {
  std::uint64_t revision = 0;  ///< after it
  std::string label;
  v1::ClientId client{};
};

struct UnexplainedPose;  // handlers/optimize.h

/// What a session holds where it is one of a motion.
struct LiveMotion {
  std::string name;
  std::shared_ptr<const manipulation::Motion> motion;
  std::shared_ptr<const geometry::TriangleMesh> object_O;  ///< that it lies on
  /// The last answer, and the revision of the edits that it answers; null before.
  std::shared_ptr<const session::SolvedMotion> solved{};
  unsigned long long solved_revision = 0;
  double solve_ms = 0.0;
  /// How it was asked to be solved last: so it is after each edit. Nothing: nobody asked yet.
  std::optional<session::MotionSolving> solving{};
  /// Made with the first solve.
  std::shared_ptr<session::MotionBench> bench{};
  std::uint64_t frames_sequence = 0;  ///< of what is published of its frames
  v1::MotionClock clock{};            ///< that all watchers share
};

/// A session as the server runs it: the editable problem, its strand, and what is told of it.
///
/// Threads: `session`, and what is said to belong to the strand, from tasks of `strand` alone;
/// the rest from any thread.
class LiveSession : public std::enable_shared_from_this<LiveSession> {
 public:
  LiveSession(std::uint64_t id,
              session::Session session,
              StrandPool& pool,
              SessionAudience& audience);

  [[nodiscard]] std::uint64_t id() const { return id_; }

  [[nodiscard]] Strand& strand() { return strand_; }

  [[nodiscard]] v1::SessionState state() const;

  /// Sets phase, message and progress, and tells the audience. Nothing follows PHASE_CLOSED.
  void enter(v1::SessionPhase phase, const std::string& message = "", double progress = 0.0);
  /// As above, but silently where edits come faster than states are of use and many wait.
  void enterSoon(v1::SessionPhase phase);
  /// Enters a phase in which nothing is done, once the pose that is out is explained; silently
  /// where an edit waits: that nothing more comes would not be true. Who refuses that edit has
  /// to tell it (`tellRest`).
  void settle(v1::SessionPhase phase);
  void tellRest();
  /// Why a step ended that was cancelled, in the phase in which the session last rested. Where
  /// it was stopped, the pose that is out is not explained either.
  void tellCancelled();
  /// As above within the present phase, at most ten times a second.
  void advance(std::string_view stage, double fraction);

  /// Cancels what runs or waits on the strand for the sake of an edit, and all that comes
  /// later.
  void cancelSolves() { solves_.cancel(); }

  [[nodiscard]] const Progress& solves() const { return solves_; }

  // === Stopping

  /// Stops the solve in flight and those that were asked for and have not begun, whoever asked
  /// for them: also by edits, which stay. `stopper` is told to those who wait.
  void stopSolving(const v1::ClientId& stopper);

  /// Likewise, where the one in flight has taken longer than that.
  void endSolveLongerThan(std::chrono::duration<double> longest);

  /// How often that was done: what was asked for at another count than the present one is
  /// stopped.
  [[nodiscard]] std::uint64_t stops() const { return stops_; }

  /// "stopped by client ab12cd34", or that its time was over: the last time.
  [[nodiscard]] std::string whoStopped() const;

  // === Edits on their way

  /// An edit was put on the strand; a solve in flight is cut short for it, but has its time
  /// first: else a stream of edits would never see an answer.
  void expectEdit();
  /// It is being applied, or was not taken.
  void meetEdit();

  [[nodiscard]] bool expectsEdits() const { return expected_edits_ > 0; }

  /// A solve or an explanation that edits may cut short, and that anybody may stop, for as long
  /// as this lives. Of the strand.
  class SolveInFlight {
   public:
    /// Has `least` before edits cut it short (0: gives way at once); `progress` is cancelled
    /// where it ends before its end. Stopped from the start if somebody stopped what was asked
    /// for then.
    SolveInFlight(LiveSession& live, Progress& progress, std::chrono::milliseconds least);
    ~SolveInFlight();
    SolveInFlight(const SolveInFlight&) = delete;
    SolveInFlight& operator=(const SolveInFlight&) = delete;

    /// Ends the solve if an edit waits and the solve had its time. From solving threads.
    void giveWay();

    [[nodiscard]] bool wasCutShort() const { return cut_short_; }

    [[nodiscard]] bool wasStopped() const { return stopped_; }

   private:
    friend class LiveSession;
    LiveSession& live_;
    Progress& progress_;
    const std::chrono::steady_clock::time_point begin_;
    const std::chrono::milliseconds least_;
    std::atomic<bool> cut_short_{false};
    std::atomic<bool> stopped_{false};
  };

  // === Idleness: from any thread

  /// Somebody asked something of it.
  void touch() { last_used_ = std::chrono::steady_clock::now().time_since_epoch().count(); }

  [[nodiscard]] std::chrono::steady_clock::duration idle() const;
  /// Puts a warning, or none, into the state and tells it if it changed.
  void warn(const std::string& warning);

  // === A demonstrator's frames

  /// Keeps the newest. True if none was waiting: somebody has to see to it then. From any
  /// thread, likewise the next.
  bool putFrame(v1::DemonstratorFrame frame);
  std::optional<v1::DemonstratorFrame> takeFrame();

  // === Of the strand

  [[nodiscard]] session::Session& session() { return session_; }

  /// Says whose it is, before anybody knows of it.
  void belongTo(std::uint64_t server_id) { state_.server_id(server_id); }

  /// The next solution's number is a later one, before anybody knows of it.
  void numberFrom(std::uint64_t number) { sequence_number_ = number; }

  /// Makes it a session of a motion, before anybody knows of it.
  void hold(LiveMotion motion);

  /// Null: it holds none.
  [[nodiscard]] LiveMotion* motion() { return motion_ ? &*motion_ : nullptr; }

  /// Numbers and publishes frames of the motion, and its clock as it stands.
  void publish(v1::MotionFrames frames);
  void publishClock();

  /// Numbers, stamps and publishes a solution; the same message is returned. A final pose also
  /// goes out as a joint command, before it is explained.
  v1::PoseSolution publish(v1::PoseSolution solution);

  /// Begins to make the solids of hand and object on `pool`, unless that was done; the next
  /// final solution waits for what is left of it. Ends with the session.
  void prepareSolids(const std::shared_ptr<LiveSession>& self, StrandPool& pool);

  /// Keeps what an edit was, for the state and for conflicts.
  void noteEdit(AppliedEdit edit);
  /// What happened after `revision`, for people: "revision 4: 'limit ...' by ab12cd34"; at most
  /// three, the newest last. `mine` are told as "your".
  [[nodiscard]] std::string editsSince(std::uint64_t revision, const v1::ClientId& mine) const;

  /// Where it is written down; null: nowhere.
  std::unique_ptr<SessionJournal> journal;
  /// It was taken out of memory: who has this looks for it again.
  bool is_asleep = false;
  /// Follows a demonstrator, as the session stood at that revision; null before the first
  /// frame.
  std::shared_ptr<session::LiveFollower> follower;
  unsigned long long follower_revision = 0;
  std::string follow_trouble;  ///< why the last frame was refused; empty: it was not
  bool solve_is_queued = false;
  std::uint64_t queued_at_stops = 0;  ///< `stops()` when the last edit came that it answers
  std::uint64_t asked_at_stops = 0;   ///< `stops()` when what runs was asked for
  /// That is out, as the session stands, and is to be explained.
  std::shared_ptr<UnexplainedPose> unexplained;
  int solves_cut_short = 0;    ///< one after another, since the last that ended by itself
  int requests_cut_short = 0;  ///< that wait behind those edits
  bool was_solved = false;     ///< and nothing of it was lost since, so that few starts do
  unsigned long long solved_revision = 0;
  // What the stages took, for the solution's times.
  double skin_ms = 0.0;             ///< of opening the session
  double transfer_ms = 0.0;         ///< of the last transfer that had something to do
  double untold_transfer_ms = 0.0;  ///< of all since the last final solution
  session::FitCheck fit_check;      ///< remembers which sizes fit

 private:
  /// The state as the session stands; `mutex_` held, of the strand.
  void describeSession();
  /// Sets a phase with what else there is to say; `mutex_` held.
  void setPhase(v1::SessionPhase phase, const std::string& message, double progress = 0.0);
  /// The phase in which the session rests, or in which the pose that is out waits for its
  /// explanation; `mutex_` held, of the strand.
  [[nodiscard]] v1::SessionPhase restingPhase() const;
  /// Tells the audience unless it knows; `mutex_` held, so that states go out in order.
  void tell();

  const std::uint64_t id_;
  session::Session session_;
  std::optional<LiveMotion> motion_;
  SessionAudience& audience_;
  Strand strand_;
  Progress solves_;
  std::uint64_t sequence_number_ = 0;
  std::deque<AppliedEdit> edits_;  ///< the last ones
  // Whose solids were begun.
  std::weak_ptr<const hand::HandModel> begun_hand_;
  std::weak_ptr<const geometry::TriangleMesh> begun_object_;
  std::atomic<int> expected_edits_{0};
  std::atomic<std::chrono::steady_clock::rep> last_used_;

  std::mutex frame_mutex_;
  std::optional<v1::DemonstratorFrame> frame_;

  mutable std::mutex flight_mutex_;
  SolveInFlight* in_flight_ = nullptr;
  std::optional<v1::ClientId> stopper_;  ///< the last one; nothing: its time was over
  std::atomic<std::uint64_t> stops_{0};

  mutable std::mutex mutex_;
  v1::SessionState state_;
  v1::SessionPhase resting_phase_ = v1::PHASE_OPEN;  ///< the last in which nothing was done
  std::string warning_;
  std::optional<v1::SessionState> told_state_;  ///< last
  std::chrono::steady_clock::time_point told_{};
};

/// The first bytes of a client's id, enough to tell it from others.
std::string shortName(const v1::ClientId& client);

/// Nanoseconds of the system's clock.
long long nowNs();

/// Runs one step of work in a phase: tells its progress, then PHASE_READY or PHASE_OPEN
/// (`after`), or why it failed. Exceptions pass through; a cancelled step leaves the phase in
/// which the session last rested. Where an edit waits, its own phase follows instead.
template <class Step>
void runPhase(LiveSession& live,
              v1::SessionPhase phase,
              v1::SessionPhase after,
              const Progress& progress,
              const Step& step) {
  live.enter(phase);
  const Progress told(progress, [&](std::string_view stage, double fraction) {
    live.advance(stage, fraction);
    progress.report(stage, fraction);
  });
  try {
    step(told);
    live.settle(after);
  } catch (const Cancelled&) {
    live.tellCancelled();
    throw;
  } catch (const std::exception& error) {
    live.enter(v1::PHASE_FAILED, error.what());
    throw;
  }
}

}  // namespace handgraft::server
