#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "core/base/progress.h"
#include "core/demonstration/posed_hand_tracker.h"
#include "core/manipulation/motion.h"
#include "core/retargeting/edited_motion.h"
#include "core/retargeting/live_follower.h"
#include "core/retargeting/motion_solving.h"
#include "core/session/session.h"
#include "core/verdict/fit_check.h"
#include "idl/motions.h"
#include "idl/sensor_msgs.h"
#include "idl/sessions.h"
#include "server/base/session_access.h"
#include "server/base/strand_pool.h"
#include "server/sessions/live_run.h"
#include "server/sessions/published_state.h"
#include "server/sessions/session_journal.h"
#include "server/sessions/solve_cycle.h"

namespace handgraft::server {

struct StoredHand;  // store/model_store.h

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

/// What a session holds where it is one of a motion.
struct LiveMotion {
  std::string name;
  std::shared_ptr<const manipulation::Motion> motion;
  std::shared_ptr<const geometry::TriangleMesh> object_O;  ///< that it lies on
  /// The last answer, and the revision of the edits that it answers; null before.
  std::shared_ptr<const retargeting::SolvedMotion> solved{};
  unsigned long long solved_revision = 0;
  double solve_ms = 0.0;
  /// How it was asked to be solved last: so it is after each edit. Nothing: nobody asked yet.
  std::optional<retargeting::MotionSolving> solving{};
  /// Made with the first solve.
  std::shared_ptr<retargeting::EditedMotion> edited{};
  std::uint64_t frames_sequence = 0;  ///< of what is published of its frames
  v1::MotionClock clock{};            ///< that all watchers share
};

/// What the stages of a solution took, for its times.
struct StagesTook {
  double skin_ms = 0.0;             ///< of opening the session
  double transfer_ms = 0.0;         ///< of the last transfer that had something to do
  double untold_transfer_ms = 0.0;  ///< of all since the last final solution
};

/// Who follows a demonstrator, as the session stood at that revision.
struct Following {
  std::shared_ptr<retargeting::LiveFollower> follower;  ///< null before the first frame
  unsigned long long revision = 0;
  /// The demonstrator's hand, if joints of a model tell it; else null, as is the next.
  std::shared_ptr<const StoredHand> hand;
  std::shared_ptr<demonstration::PosedHandTracker> tracker;
  /// Whose frames they are, the last one's number, and when it came.
  v1::ClientId client{};
  unsigned long long sequence_number = 0;
  SolveCycle::Clock::time_point heard{};
  LiveRun run;  ///< of this demonstrator
};

/// A session as the server runs it: the editable problem, its strand, where it stands between
/// edits and poses (`cycle`), and what is told of it.
///
/// Threads: `session`, and what is said to belong to the strand, from tasks of `strand` alone;
/// the rest from any thread. Nothing is published while a lock is held that others wait for.
class LiveSession : public std::enable_shared_from_this<LiveSession> {
 public:
  /// `now` is its clock.
  LiveSession(std::uint64_t id,
              session::Session session,
              StrandPool& pool,
              SessionAudience& audience,
              SolveCycle::Now now = SolveCycle::Clock::now);

  [[nodiscard]] std::uint64_t id() const { return id_; }

  [[nodiscard]] Strand& strand() { return strand_; }

  /// Edits, solves, stops, and the pose that is out.
  [[nodiscard]] SolveCycle& cycle() { return cycle_; }

  // === Its state

  [[nodiscard]] v1::SessionState state() const { return published_.get(); }

  [[nodiscard]] bool isClosed() const { return published_.isClosed(); }

  /// Sets phase, message and progress, and tells the audience. Nothing follows PHASE_CLOSED.
  void enter(v1::SessionPhase phase, const std::string& message = "", double progress = 0.0);
  /// As above, but silently where edits come faster than states are of use and many wait.
  void enterSoon(v1::SessionPhase phase);
  /// Enters a phase in which nothing is done, once the pose that is out is diagnosed; silently
  /// where an edit waits: that nothing more comes would not be true. Who refuses that edit has
  /// to tell it (`tellRest`).
  void settle(v1::SessionPhase phase);
  void tellRest();
  /// A step ended before its end: so, in the phase in which the session last rested. Where it
  /// was stopped, the pose that is out is not diagnosed either.
  void tellEnd(SolveEnd end);
  /// As above within the present phase, at most ten times a second.
  void advance(std::string_view stage, double fraction);

  /// Cancels what runs or waits on the strand for the sake of an edit, and all that comes
  /// later.
  void cancelSolves() { solves_.cancel(); }

  [[nodiscard]] const Progress& solves() const { return solves_; }

  // === Whose it is

  [[nodiscard]] SessionAccess access() const;

  /// Tells it; before anybody knows of the session, silently.
  void grant(SessionAccess access, PublishPolicy telling = PublishedState::kAtOnce);

  // === Idleness

  /// Somebody asked something of it.
  void touch() { last_used_ = now_().time_since_epoch().count(); }

  [[nodiscard]] SolveCycle::Clock::time_point now() const { return now_(); }

  [[nodiscard]] std::chrono::steady_clock::duration idle() const;
  /// Puts a warning that it will be closed, or none, into the state and tells it if it changed.
  void warnOfClosing(const std::string& warning);

  // === A demonstrator's frames

  /// Puts what is said of the newest frame into the state and tells it if it changed.
  void tellDemonstrator(const v1::FollowState& said);
  /// Keeps the newest. True if none was waiting: somebody has to see to it then.
  bool putFrame(v1::DemonstratorFrame frame);
  std::optional<v1::DemonstratorFrame> takeFrame();

  // === Of the strand

  [[nodiscard]] session::Session& session() { return session_; }

  /// Says whose it is, before anybody knows of it.
  void belongTo(std::uint64_t server_id);

  /// The next solution's number is a later one, before anybody knows of it.
  void numberFrom(std::uint64_t number) { sequence_number_ = number; }

  /// It stands as it was left then (ns of the system's clock), and what is published of this
  /// revision says so, until it is solved or led on wish (0): a hand's motors must tell what a
  /// store kept from what somebody wants now.
  void recallFrom(std::int64_t left_ns);

  /// Makes it a session of a motion, before anybody knows of it.
  void hold(LiveMotion motion);

  /// Null: it holds none.
  [[nodiscard]] LiveMotion* motion() { return motion_ ? &*motion_ : nullptr; }

  /// Numbers and publishes frames of the motion, and its clock as it stands.
  void publish(v1::MotionFrames frames);
  void publishClock();

  /// Numbers, stamps and publishes a solution; the same message is returned. A final pose also
  /// goes out as a joint command, before it is diagnosed.
  v1::PoseSolution publish(v1::PoseSolution solution);

  /// The final pose of this revision as it was published diagnosed; null: there is none yet.
  [[nodiscard]] const v1::PoseSolution* diagnosed() const;

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
  Following following;
  StagesTook took;
  verdict::FitCheck fit_check;  ///< remembers which sizes fit

 private:
  /// The session as it stands, into a state that is being changed; of the strand.
  void describeSession(v1::SessionState& state) const;
  /// Sets a phase with what else there is to say, in a state that is being changed.
  void setPhase(v1::SessionState& state,
                v1::SessionPhase phase,
                const std::string& message,
                double progress = 0.0);
  /// The phase in which the session rests, or in which the pose that is out waits for its
  /// diagnosis; as above, of the strand.
  [[nodiscard]] v1::SessionPhase restingPhase() const;
  /// Silent where an edit waits.
  [[nodiscard]] PublishPolicy unlessEditsWait() const;

  const std::uint64_t id_;
  const SolveCycle::Now now_;
  session::Session session_;
  std::optional<LiveMotion> motion_;
  SessionAudience& audience_;
  Strand strand_;
  SolveCycle cycle_;
  Progress solves_;
  std::uint64_t sequence_number_ = 0;
  std::int64_t left_ns_ = 0;  ///< 0: it is in use
  std::uint64_t left_revision_ = 0;
  std::optional<v1::PoseSolution> diagnosed_;  ///< the last final pose, once it is
  std::deque<AppliedEdit> edits_;              ///< the last ones
  // Whose solids were begun.
  std::weak_ptr<const hand::HandModel> begun_hand_;
  std::weak_ptr<const geometry::TriangleMesh> begun_object_;
  std::atomic<std::chrono::steady_clock::rep> last_used_;

  std::mutex frame_mutex_;
  std::optional<v1::DemonstratorFrame> frame_;

  mutable std::mutex access_mutex_;
  SessionAccess access_;

  PublishedState published_;
  // Of changes of `published_`.
  v1::SessionPhase resting_phase_ = v1::PHASE_OPEN;  ///< the last in which nothing was done
  std::string closing_;                              ///< empty: it is not about to be
  /// What the message says while nothing else is told.
  [[nodiscard]] std::string warning(const v1::SessionState& state) const;
  /// `changes` changes what that is made of; false: it did not.
  void warn(const std::function<bool(v1::SessionState&)>& changes);
};

/// Nanoseconds of the system's clock.
long long nowNs();

}  // namespace handgraft::server
