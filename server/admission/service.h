#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <tuple>
#include <utility>
#include <vector>

#include "core/base/progress.h"
#include "server/admission/error_reply.h"
#include "server/admission/operations.h"
#include "server/admission/packed_reply.h"
#include "server/admission/request_deduplication.h"
#include "server/handlers/handler_context.h"
#include "server/handlers/persisted_models.h"
#include "server/sessions/live_session.h"
#include "server/store/upload_reader.h"
#include "server/transport/bus.h"

namespace handgraft::server {

struct ServiceOptions {
  static constexpr std::chrono::hours kNever{1'000'000};

  std::string name;                ///< by which clients choose it among others of the domain
  std::size_t workers = 2;         ///< for slow work; quick requests have a thread of their own
  std::size_t most_waiting = 256;  ///< tasks that may queue; more are refused
  std::chrono::milliseconds patience = StrandPool::kPatience;  ///< of idle tasks
  /// Threads that help where all workers have long tasks (StrandPool).
  std::size_t reserves = 0;
  /// A request that its client has not repeated for so long is given up: the client is gone.
  std::chrono::seconds forsaken = kNever;
  /// Of computing, a request or the solve that follows an edit; a request may ask for less.
  std::chrono::duration<double> budget = kNever;
  std::size_t most_per_client = 32;     ///< requests of one client that may be unanswered
  std::size_t most_bytes = 256u << 20;  ///< of memory, of all unanswered requests
  std::size_t most_sessions = 256;
  /// A session that nobody asks anything of for so long is closed; its state warns of it in the
  /// last tenth, at most ten minutes before.
  std::chrono::seconds session_idle{std::chrono::hours(12)};
  /// Keeps what clients were told of over the end of this process; must outlive the service.
  /// Null: nothing outlives it.
  StateStore* state = nullptr;
  std::filesystem::path reader = readerProgram();  ///< reads uploads (upload_reader.h)
  ReaderLimits reader_limits;
};

/// The server between the bus and the handlers: does every request once, each session's work in
/// order and sessions in parallel, and is the only place where exceptions become replies
/// (error_reply.h).
///
/// Threads: `start` and `stop` from one thread; the rest runs on threads of its own (README).
class Service final : private BusListener, private SessionAudience {
 public:
  /// `bus` and `models` must outlive the service. Errors: InvalidInput if there is no reader.
  Service(Bus& bus, ModelStore& models, const ServiceOptions& options);
  /// Stops if that was not done.
  ~Service() override;
  Service(const Service&) = delete;
  Service& operator=(const Service&) = delete;

  void start();
  /// Hears nothing more, cancels what runs, answers it, closes sessions, says goodbye. Where
  /// sessions outlive it, none is closed, and no goodbye is said: it will be back.
  void stop();

  [[nodiscard]] v1::ServerStatus status() const;

 private:
  /// A client as it calls itself, of the participant that DDS names: who claims another's name
  /// is not taken for it.
  struct RequestOrigin {
    Sender sender{};
    v1::ClientId client{};

    bool operator==(const RequestOrigin&) const = default;

    bool operator<(const RequestOrigin& other) const {
      return std::tie(sender, client) < std::tie(other.sender, other.client);
    }
  };

  using Key = std::pair<RequestOrigin, std::uint64_t>;
  using Requests = RequestDeduplication<PackedReply, RequestOrigin>;
  using Edits = RequestDeduplication<v1::EditReply, RequestOrigin>;

  /// A request on its way through the server.
  struct Job {
    v1::Request request;
    const RequestOrigin asker;
    Progress progress;
    std::chrono::steady_clock::time_point told{};
    std::string told_stage;
    std::size_t bytes = 0;          ///< of the request in memory, once it is admitted
    SolveCycle::StopEpoch asked{};  ///< of its session, when it came
    // Of `running_mutex_`.
    std::chrono::steady_clock::time_point heard = std::chrono::steady_clock::now();  ///< last
    std::optional<std::chrono::steady_clock::time_point> begun;  ///< computing
    std::optional<ErrorReply> ended;                             ///< by us, and why
    /// An edit cut it short at this revision, and it waits for what becomes of that edit.
    std::optional<std::uint64_t> cut_short_at;

    Job(v1::Request what, const Sender& sender, Service& service);
  };

  using JobPtr = std::shared_ptr<Job>;

  // === BusListener, SessionAudience
  void onRequest(v1::Request request, const Sender& sender) override;
  void onEdit(v1::Edit edit, const Sender& sender) override;
  void onDemonstrator(v1::DemonstratorFrame frame, const Sender& sender) override;
  void onGone(const Sender& sender) override;
  void onStatus(const v1::ServerStatus& status) override;
  void onState(const v1::SessionState& state) override;
  void onSolution(const v1::PoseSolution& solution) override;
  void onMotionFrames(const v1::MotionFrames& frames) override;
  void onClock(const v1::MotionClock& clock) override;
  void onJointCommand(std::uint64_t session_id,
                      const sensor_msgs::msg::dds_::JointState_& command) override;

  // === Sessions that sleep
  using WithSession = std::function<void(const std::shared_ptr<LiveSession>&)>;
  using WithoutSession = std::function<void(const std::exception_ptr&)>;
  /// `then` of an open session at once; of one that sleeps once it is open, in the order in
  /// which it was asked for. Else `otherwise`, with what was in the way. Both return soon.
  void whenOpen(std::uint64_t id, WithSession then, const WithoutSession& otherwise);
  void wake(std::uint64_t id);
  /// Those of which nothing was asked for long, and so many more as others need the room.
  void putIdleSessionsToSleep();
  /// On its strand, where nothing was asked of it for so long.
  void putToSleepAfter(const std::shared_ptr<LiveSession>& live, std::chrono::seconds idle);
  void listKeptSessions();
  /// Those that were in use when the server before this one ended: who only watches asks
  /// nothing.
  void wakeTheLastUsed();

  // === Requests
  /// Errors: Rejection (ERROR_OTHER_SERVER) unless it is this one, or 0.
  void requireMeant(std::uint64_t server_id) const;
  /// Says what `check` throws, without remembering it: what is meant for another server may
  /// come again, meant for this one. False then.
  template <class Reply>
  bool passes(Reply reply, const Sender& sender, const std::function<void()>& check);
  void admit(const JobPtr& job);
  void dispatch(const JobPtr& job);
  void dispatchToSession(const JobPtr& job);
  [[nodiscard]] Call callOf(const Job& job, LiveSession* live = nullptr);
  /// Does the work and answers, with its error if need be; false, and nothing is answered, if
  /// an edit cut it short.
  bool answerWith(const JobPtr& job, const std::function<std::optional<v1::ReplyBody>()>& work);
  void refuse(const JobPtr& job, const std::exception_ptr& trouble);
  void stopSolving(std::uint64_t session_id, const RequestOrigin& stopper);
  void runOfSession(const JobPtr& job, const std::shared_ptr<LiveSession>& live);
  void answer(const Job& job, v1::Reply reply);
  void cancel(const RequestOrigin& asker, std::uint64_t request_id);
  void tell(Job& job, std::string_view stage, double fraction);

  // === Edits
  /// `asked`: when the edit came.
  void runEdit(const std::shared_ptr<LiveSession>& live,
               const RequestOrigin& asker,
               const std::shared_ptr<const v1::Edit>& shared,
               SolveCycle::StopEpoch asked);
  void dispatchEdit(const RequestOrigin& asker, const std::shared_ptr<const v1::Edit>& edit);
  /// What a server before this one answered.
  [[nodiscard]] std::optional<v1::EditReply> editBefore(const RequestOrigin& asker,
                                                        const v1::Edit& edit) const;
  /// Answers with the exception that is being handled.
  void refuseEdit(const RequestOrigin& asker, const v1::Edit& edit, std::uint64_t revision);
  void answerEdit(const RequestOrigin& asker, const v1::Edit& edit, v1::EditReply reply);
  void queueSolve(const std::shared_ptr<LiveSession>& live);

  /// It was repeated: somebody still waits for it.
  void hearAgain(const Key& key);
  /// Nobody could be heard for so long.
  void forgive(std::chrono::steady_clock::duration held_up);
  /// Cancels what nobody waits for any more, and what has had its time.
  void cancelAbandonedAndOverdue();
  void publishStatusOnceASecond();
  void expireIdleSessions();

  Bus& bus_;
  const ServiceOptions options_;
  const std::uint64_t server_id_;
  const bool is_secured_;  ///< it knows who asks
  const std::chrono::steady_clock::time_point started_;
  std::atomic<std::uint64_t> answered_{0};
  std::atomic<bool> stopping_{false};

  Requests requests_;
  /// Small answers; a client that could not be heard for a while has many edits under way.
  Edits edits_{{.answers_per_client = 512}};
  /// Other servers of this domain, and when each was last told of; on the bus' one thread.
  std::map<std::uint64_t, std::chrono::steady_clock::time_point> rivals_;
  mutable std::mutex running_mutex_;
  std::map<Key, JobPtr> running_;
  std::size_t running_bytes_ = 0;

  UploadStore uploads_;
  UploadReader reader_;
  SessionStore sessions_;
  std::shared_ptr<PersistedModels> persisted_models_;

  struct Waiting {
    WithSession then;
    WithoutSession otherwise;
  };

  std::mutex waking_mutex_;
  std::map<std::uint64_t, std::vector<Waiting>> waking_;
  std::vector<std::uint64_t> last_used_;  ///< sessions, when the server began
  StrandPool quick_;
  StrandPool pool_;
  HandlerContext context_;

  std::mutex status_mutex_;
  std::condition_variable status_wake_;
  std::thread status_thread_;
};

}  // namespace handgraft::server
