#include "server/admission/service.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include "core/base/error.h"
#include "core/base/random_id.h"
#include "idl/check.h"
#include "idl/operations.h"
#include "server/admission/error_reply.h"
#include "server/admission/rejection.h"
#include "server/admission/session_rights.h"
#include "server/handlers/kept_sessions.h"
#include "server/handlers/sessions.h"
#include "server/handlers/solving_phase.h"

namespace handgraft::server {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kMostQuickWaiting = 256;   // chunks of files among them
constexpr std::chrono::seconds kIdleInNeed(10);  // of sessions where others find no room
// A client that waits repeats what it asks every 2 s at least, and gives up after 30 s of
// silence (idl/cyclone/requester).
constexpr std::chrono::seconds kAnswersKept(120);

std::string hostName() {
  std::string name(256, '\0');
  if (gethostname(name.data(), name.size() - 1) != 0) return "";
  name.resize(name.find('\0'));
  return name;
}

std::string inWords(std::chrono::steady_clock::duration time) {
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(time).count();
  constexpr long kMinute = 60;
  constexpr long kHour = 3600;
  if (seconds < 2 * kMinute) return fmt::format("{} s", seconds);
  if (seconds < 2 * kHour) return fmt::format("{} min", seconds / kMinute);
  return fmt::format("{} h {} min", seconds / kHour, seconds % kHour / kMinute);
}

}  // namespace

Service::Job::Job(v1::Request what, const Sender& sender, Service& service)
    : request(std::move(what)),
      asker{sender, request.client()},
      progress([this, &service](std::string_view stage, double part) {
        service.tell(*this, stage, part);
      }) {}

Service::Service(Bus& bus, ModelStore& models, const ServiceOptions& options)
    : bus_(bus),
      options_(options),
      server_id_(options.state != nullptr ? options.state->serverId() : randomId()),
      started_(Clock::now()),
      reader_(options.reader, options.reader_limits),
      sessions_(server_id_, options.most_sessions),
      kept_models_(options.state != nullptr
                       ? std::make_shared<KeptModels>(*options.state, models)
                       : nullptr),
      quick_(1, kMostQuickWaiting),
      pool_(options.workers, options.most_waiting, options.patience, options.reserves),
      workshop_{models,        uploads_,           reader_, sessions_, *this, pool_,
                options.state, kept_models_.get(), &bus_} {
  if (options.state == nullptr) return;
  kept_models_->listIn(models);
  listKeptSessions();
}

Service::~Service() {
  stop();
}

void Service::start() {
  wakeTheLastUsed();
  bus_.start(*this);
  status_thread_ = std::thread([this] {
    publishStatusOnceASecond();
  });
}

void Service::stop() {
  if (stopping_.exchange(true)) return;
  bus_.stop();
  {
    const std::lock_guard lock(running_mutex_);
    for (const auto& [key, job] : running_)
      job->progress.cancel();
  }
  for (const auto& live : sessions_.all())
    live->cancelSolves();
  quick_.shut();
  pool_.shut();
  for (const auto& live : sessions_.all()) {
    try {
      if (live->journal == nullptr) {
        closeSession(*live, workshop_, {});
      } else if (live->journal->entriesSinceText() > 0) {
        keepText(*live);
      }
    } catch (const std::exception& error) {  // its history is there, as far as it was told
      spdlog::warn("event=store_waits session={} what={}", live->id(),
                   handgraft::quoted(error.what()));
    }
  }
  {
    const std::lock_guard lock(status_mutex_);
    status_wake_.notify_all();
  }
  if (status_thread_.joinable()) status_thread_.join();
  bus_.publish(status());
  bus_.flush();
}

v1::ServerStatus Service::status() const {
  v1::ServerStatus message;
  message.server_id(server_id_);
  message.protocol_version(v1::PROTOCOL_VERSION);
  message.version(HANDGRAFT_VERSION);
  message.host(hostName());
  message.process_id(static_cast<std::uint32_t>(getpid()));
  message.uptime_s(std::chrono::duration<double>(Clock::now() - started_).count());
  message.model_count(static_cast<std::uint32_t>(workshop_.models.size()));
  message.session_count(static_cast<std::uint32_t>(sessions_.countAll()));
  message.requests_answered(answered_);
  {
    const std::lock_guard lock(running_mutex_);
    message.requests_running(static_cast<std::uint32_t>(running_.size()));
  }
  message.stopping(stopping_ && options_.state == nullptr);
  message.name(options_.name);
  return message;
}

void Service::publishStatusOnceASecond() {
  constexpr std::chrono::seconds kHeldUp(1);  // beyond the second between two rounds
  std::unique_lock lock(status_mutex_);
  Clock::time_point last = Clock::now();
  while (!stopping_) {
    bus_.publish(status());
    bus_.lookAround();
    uploads_.dropIdle();
    expireIdleSessions();
    // What was not heard while this server itself did not get its turn is no client's silence.
    const Clock::time_point now = Clock::now();
    const Clock::duration held_up = now - std::exchange(last, now) - std::chrono::seconds(1);
    if (held_up > kHeldUp) forgive(held_up);
    endForsakenAndLong();
    requests_.forgetSilent(kAnswersKept);
    edits_.forgetSilent(kAnswersKept);
    status_wake_.wait_for(lock, std::chrono::seconds(1), [this] {
      return stopping_.load();
    });
  }
}

void Service::hearAgain(const Key& key) {
  const std::lock_guard lock(running_mutex_);
  const auto found = running_.find(key);
  if (found != running_.end()) found->second->heard = Clock::now();
}

void Service::forgive(Clock::duration held_up) {
  const Clock::time_point now = Clock::now();
  const std::lock_guard lock(running_mutex_);
  for (const auto& [key, job] : running_)
    job->heard = std::min(now, job->heard + held_up);
}

void Service::endForsakenAndLong() {
  const Clock::time_point now = Clock::now();
  {
    const std::lock_guard lock(running_mutex_);
    for (const auto& [key, job] : running_) {
      if (job->ended) continue;
      const double asked = job->request.budget_s();
      const std::chrono::duration<double> budget =
          asked > 0.0 ? std::min(options_.budget, std::chrono::duration<double>(asked))
                      : options_.budget;
      if (now - job->heard > options_.forsaken) {
        job->ended = {v1::ERROR_CANCELLED, "given up: its client does not ask for it any more",
                      ""};
      } else if (job->begun && now - *job->begun > budget) {
        job->ended = {v1::ERROR_OUT_OF_TIME,
                      fmt::format("ended after {:.6g} s of computing, all that it was given",
                                  budget.count()),
                      ""};
      } else {
        continue;
      }
      job->progress.cancel();
    }
  }
  for (const auto& live : sessions_.all())
    live->cycle().stopLongerThan(options_.budget);
}

void Service::expireIdleSessions() {
  constexpr std::chrono::minutes kLongestWarning(10);
  const Clock::duration limit = options_.session_idle;
  const Clock::duration warning = std::min<Clock::duration>(limit / 10, kLongestWarning);
  for (const auto& live : sessions_.all()) {
    const Clock::duration idle = live->idle();
    if (options_.state != nullptr) {
      const bool is_full = 10 * sessions_.size() > 9 * options_.most_sessions;
      if (idle >= (is_full ? std::min<Clock::duration>(limit, kIdleInNeed) : limit))
        putToSleepAfter(live, std::chrono::duration_cast<std::chrono::seconds>(idle));
    } else if (idle < limit - warning) {
      live->warn("");
    } else if (idle < limit) {
      live->warn(fmt::format("idle; closes within {} unless it is used", inWords(warning)));
    } else {
      const bool is_taken = live->strand().post([this, live, limit] {
        if (live->idle() < limit || live->isClosed()) return;
        spdlog::info("event=session_expired session={}", live->id());
        closeSession(*live, workshop_, {}, "idle for " + inWords(limit));
      });
      if (!is_taken) spdlog::debug("event=expiry_waits session={}", live->id());
    }
  }
}

void Service::onGone(const Sender& sender) {
  // Files are removed, which DDS' thread need not wait for; what finds no room is dropped once
  // it is idle.
  static_cast<void>(quick_.post([this, sender] {
    uploads_.drop(sender);
  }));
}

void Service::onStatus(const v1::ServerStatus& status) {
  constexpr std::size_t kMostRivals = 16;
  constexpr std::chrono::minutes kPeriod(10);
  if (status.server_id() == server_id_ || status.stopping()) return;
  if (status.name() != options_.name) return;
  const Clock::time_point now = Clock::now();
  std::erase_if(rivals_, [&](const auto& one) {
    return now - one.second > kPeriod;
  });
  // Anybody may say that he is a server: that ends nothing here, and fills nothing.
  if (rivals_.size() >= kMostRivals || !rivals_.try_emplace(status.server_id(), now).second)
    return;
  spdlog::warn(
      "event=another_server id={} host={} process={} reason=\"another server answers on this "
      "domain, too; clients stay with the one they met first: stop one of them, or give it a "
      "--name\"",
      status.server_id(), handgraft::quoted(status.host()), status.process_id());
}

// === What the world hears of sessions

void Service::onState(const v1::SessionState& state) {
  bus_.publish(state);
}

void Service::onSolution(const v1::PoseSolution& solution) {
  bus_.publish(solution);
}

void Service::onMotionFrames(const v1::MotionFrames& frames) {
  bus_.publish(frames);
}

void Service::onClock(const v1::MotionClock& clock) {
  bus_.publish(clock);
}

void Service::onJointCommand(std::uint64_t session_id,
                             const sensor_msgs::msg::dds_::JointState_& command) {
  bus_.publishJointCommand(session_id, command);
}

// === Requests: admitted once, dispatched to a thread, answered

template <class Reply>
bool Service::passes(Reply reply, const std::function<void()>& check) {
  try {
    check();
    return true;
  } catch (...) {
    ErrorReply error = errorReplyOf(std::current_exception());
    reply.error(error.code);
    reply.message(std::move(error.message));
    reply.server_id(server_id_);
    bus_.publish(reply);
    return false;
  }
}

template bool Service::passes(v1::Reply, const std::function<void()>&);
template bool Service::passes(v1::EditReply, const std::function<void()>&);

void Service::onRequest(v1::Request request, const Sender& sender) {
  v1::Reply reply;
  reply.client(request.client());
  reply.request_id(request.request_id());
  if (!passes(reply, [&] {
        requireMeant(request.server_id());
      }))
    return;
  const auto job = std::make_shared<Job>(std::move(request), sender, *this);
  const auto begun = requests_.begin(job->asker, job->request.request_id());
  switch (begun.verdict) {
    case Requests::Verdict::kRunning:
      return hearAgain({job->asker, job->request.request_id()});
    case Requests::Verdict::kForgotten:
      passes(reply, [&] {
        rejectForgotten("request", reply.request_id());
      });
      return;
    case Requests::Verdict::kAnswered:
      bus_.publishAgain(*begun.answer);
      return;
    case Requests::Verdict::kNew:
      break;
  }
  try {
    admit(job);
    if (auto before = replyBefore(callOf(*job))) {
      answerWith(job, [&] {
        return before;
      });
      return;
    }
    dispatch(job);
  } catch (...) {
    refuse(job, std::current_exception());
  }
}

Call Service::callOf(const Job& job, LiveSession* live) {
  return {job.request, job.asker.sender, workshop_, job.progress, live};
}

void Service::requireMeant(std::uint64_t server_id) const {
  if (server_id == 0 || server_id == server_id_) return;
  reject(v1::ERROR_OTHER_SERVER, "this is server {}; {} was meant", server_id_, server_id);
}

void Service::admit(const JobPtr& job) {
  const v1::Request& request = job->request;
  if (request.protocol_version() != v1::PROTOCOL_VERSION) {
    reject(v1::ERROR_VERSION, "this server ({}) speaks protocol {}, the request protocol {}",
           HANDGRAFT_VERSION, v1::PROTOCOL_VERSION, request.protocol_version());
  }
  idl::check(request);
  const std::lock_guard lock(running_mutex_);
  const Sender& sender = job->asker.sender;
  std::size_t mine = 0;
  for (auto at = running_.lower_bound({Asker{sender, {}}, 0});
       at != running_.end() && at->first.first.sender == sender; ++at)
    ++mine;
  if (mine >= options_.most_per_client) {
    reject(v1::ERROR_OVERLOADED, "{} requests of this client are unanswered", mine);
  }
  // Messages take more memory than wire: short strings and small structures several times as
  // much, and all of it once more where it becomes other types.
  constexpr std::size_t kMemoryPerByte = 4;
  const std::size_t bytes = kMemoryPerByte * v1::Request::getCdrSerializedSize(request);
  if (bytes > options_.most_bytes - running_bytes_) {
    reject(
        v1::ERROR_OVERLOADED,
        "a request that takes {} bytes of memory is too much beside the {} bytes of those that "
        "wait, of at most {}; try later",
        bytes, running_bytes_, options_.most_bytes);
  }
  job->bytes = bytes;
  running_bytes_ += bytes;
  running_[{job->asker, request.request_id()}] = job;
}

void Service::dispatch(const JobPtr& job) {
  const v1::RequestBody& body = job->request.body();
  const auto work = [this, job] {
    answerWith(job, [&] {
      return perform(callOf(*job));
    });
  };
  bool is_taken = true;
  switch (laneOf(body._d())) {
    case Lane::kAtOnce:
      if (body._d() == v1::OP_CANCEL) {
        cancel(job->asker, body.cancel().request_id());
      } else {
        stopSolving(idl::sessionOf(body), job->asker);
      }
      answerWith(job, [&] {
        return nothingSaid(body._d());
      });
      break;
    case Lane::kQuick:
      if (body._d() == v1::OP_DESCRIBE_SESSION && sessions_.asleep(idl::sessionOf(body))) {
        // Who asks for it is going to watch it.
        whenOpen(
            idl::sessionOf(body), [](const auto&) {}, [](const auto&) {});
      }
      is_taken = quick_.post(work);
      break;
    case Lane::kPool:
      is_taken = pool_.post(work);
      break;
    case Lane::kSession:
      return dispatchToSession(job);
  }
  if (!is_taken) reject(v1::ERROR_OVERLOADED, "too many requests wait; try later");
}

void Service::dispatchToSession(const JobPtr& job) {
  whenOpen(
      idl::sessionOf(job->request.body()),
      [this, job](const std::shared_ptr<LiveSession>& live) {
        requireMayDo(job->request.body()._d(), *live, bus_.whoIs(job->asker.sender));
        live->touch();
        if (job->request.body()._d() == v1::OP_CLOSE_SESSION) live->cancelSolves();
        job->asked = live->cycle().asked();
        const bool is_taken = live->strand().post([this, job, live] {
          runOfSession(job, live);
        });
        if (!is_taken) reject(v1::ERROR_OVERLOADED, "too many requests wait; try later");
      },
      [this, job](const std::exception_ptr& trouble) {
        refuse(job, trouble);
      });
}

void Service::stopSolving(std::uint64_t session_id, const Asker& stopper) {
  if (sessions_.asleep(session_id)) return;  // nothing is solved there
  const std::shared_ptr<LiveSession> live = sessions_.find(session_id);
  requireMayDo(v1::OP_STOP_SOLVING, *live, bus_.whoIs(stopper.sender));
  live->touch();
  live->cycle().stop(stopper.client);
}

void Service::refuse(const JobPtr& job, const std::exception_ptr& trouble) {
  answerWith(job, [&]() -> std::optional<v1::ReplyBody> {
    std::rethrow_exception(trouble);
  });
}

bool Service::answerWith(const JobPtr& job,
                         const std::function<std::optional<v1::ReplyBody>()>& work) {
  const Clock::time_point begin = Clock::now();
  {
    const std::lock_guard lock(running_mutex_);
    if (!job->begun) job->begun = begin;
  }
  v1::Reply reply;
  try {
    job->progress.checkpoint();
    std::optional<v1::ReplyBody> body = work();
    if (!body) return false;
    reply.body(*std::move(body));
  } catch (...) {
    ErrorReply error = errorReplyOf(std::current_exception());
    if (error.code == v1::ERROR_CANCELLED) {
      const std::lock_guard lock(running_mutex_);
      if (job->ended) error = *job->ended;
    }
    reply.error(error.code);
    reply.message(std::move(error.message));
    reply.field(std::move(error.field));
  }
  const v1::Request& request = job->request;
  spdlog::log(reply.error() == v1::ERROR_NONE ? spdlog::level::debug : spdlog::level::info,
              "event=request client={} id={} operation={} ms={:.3f} error={} message={}",
              shortName(request.client()), request.request_id(), nameOf(request.body()._d()),
              std::chrono::duration<double, std::milli>(Clock::now() - begin).count(),
              static_cast<unsigned>(reply.error()), handgraft::quoted(reply.message()));
  answer(*job, std::move(reply));
  return true;
}

void Service::runOfSession(const JobPtr& job, const std::shared_ptr<LiveSession>& live) {
  if (live->is_asleep) return dispatchToSession(job);
  live->cycle().workFor(job->asked);
  const bool is_answered = answerWith(job, [&] {
    const std::uint64_t revision = live->session().revision();
    // Had the edit that cut it short been refused, it would be begun again.
    if (job->cut_short_at && *job->cut_short_at != revision) rejectOutdated(live->id());
    return perform(callOf(*job, live.get()));
  });
  if (is_answered) return;
  job->cut_short_at = live->session().revision();
  live->cycle().requestWaits();
  live->strand().postFromTask([this, job, live] {
    live->cycle().requestGoesOn();
    runOfSession(job, live);
  });
}

void Service::answer(const Job& job, v1::Reply reply) {
  const std::uint64_t id = job.request.request_id();
  reply.client(job.asker.client);
  reply.request_id(id);
  reply.server_id(server_id_);
  const std::size_t bytes = v1::Reply::getCdrSerializedSize(reply);
  const auto kept = requests_.answer(job.asker, id, std::move(reply), bytes);
  {
    const std::lock_guard lock(running_mutex_);
    running_.erase({job.asker, id});
    running_bytes_ -= job.bytes;
  }
  ++answered_;
  bus_.publish(*kept);
}

void Service::cancel(const Asker& asker, std::uint64_t request_id) {
  {
    const std::lock_guard lock(running_mutex_);
    const auto found = running_.find({asker, request_id});
    if (found != running_.end()) {
      found->second->progress.cancel();
      return;
    }
  }
  // It may have been overtaken: then it finds this answer when it arrives. If it has one
  // already, that one stands.
  v1::Reply reply;
  reply.client(asker.client);
  reply.request_id(request_id);
  reply.server_id(server_id_);
  reply.error(v1::ERROR_CANCELLED);
  reply.message(Cancelled().what());
  const std::size_t bytes = v1::Reply::getCdrSerializedSize(reply);
  requests_.answer(asker, request_id, std::move(reply), bytes);
}

void Service::tell(Job& job, std::string_view stage, double fraction) {
  constexpr std::chrono::milliseconds kPeriod(50);
  const Clock::time_point now = Clock::now();
  if (now - job.told < kPeriod && stage == job.told_stage) return;
  job.told = now;
  job.told_stage = stage;
  v1::Progress message;
  message.client(job.request.client());
  message.request_id(job.request.request_id());
  message.stage(job.told_stage);
  message.fraction(fraction);
  bus_.publish(message);
}

}  // namespace handgraft::server
