#include "server/admission/service.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>
#include <unistd.h>

#include "core/base/error.h"
#include "core/base/random_id.h"
#include "server/admission/error_reply.h"
#include "server/handlers/kept_sessions.h"
#include "server/handlers/sessions.h"
#include "server/log/log.h"

namespace handgraft::server {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kMostQuickWaiting = 256;  // chunks of files among them
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

Service::Service(Bus& bus, ModelStore& models, const ServiceOptions& options)
    : bus_(bus),
      options_(options),
      server_id_(options.state != nullptr ? options.state->serverId() : randomId()),
      is_secured_(bus.whoIs({}).has_value()),
      started_(Clock::now()),
      reader_(options.reader, options.reader_limits),
      sessions_(server_id_, options.most_sessions),
      persisted_models_(options.state != nullptr
                            ? std::make_shared<PersistedModels>(*options.state, models)
                            : nullptr),
      quick_(1, kMostQuickWaiting),
      pool_(options.workers, options.most_waiting, options.patience, options.reserves),
      context_{models, uploads_, reader_,       sessions_,
               *this,  pool_,    options.state, persisted_models_.get(),
               &bus_} {
  if (options.state == nullptr) return;
  persisted_models_->listIn(models);
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
        closeSession(*live, context_, {});
      } else if (live->journal->entriesSinceText() > 0) {
        keepText(*live);
      }
    } catch (const std::exception& error) {  // its history is there, as far as it was told
      log::warn("event=store_waits session={} what={}", live->id(),
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
  message.model_count(static_cast<std::uint32_t>(context_.models.size()));
  message.session_count(static_cast<std::uint32_t>(sessions_.countAll()));
  message.requests_answered(answered_);
  {
    const std::lock_guard lock(running_mutex_);
    message.requests_running(static_cast<std::uint32_t>(running_.size()));
  }
  message.stopping(stopping_ && options_.state == nullptr);
  message.name(options_.name);
  message.secured(is_secured_);
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
    cancelAbandonedAndOverdue();
    requests_.forgetSilent(kAnswersKept);
    edits_.forgetSilent(kAnswersKept);
    status_wake_.wait_for(lock, std::chrono::seconds(1), [this] {
      return stopping_.load();
    });
  }
}

void Service::forgive(Clock::duration held_up) {
  const Clock::time_point now = Clock::now();
  const std::lock_guard lock(running_mutex_);
  for (const auto& [key, job] : running_)
    job->heard = std::min(now, job->heard + held_up);
}

void Service::cancelAbandonedAndOverdue() {
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
  if (options_.state != nullptr) return putIdleSessionsToSleep();
  for (const auto& live : sessions_.all()) {
    const Clock::duration idle = live->idle();
    if (idle < limit - warning) {
      live->warnOfClosing("");
    } else if (idle < limit) {
      live->warnOfClosing(
          fmt::format("idle; closes within {} unless it is used", inWords(warning)));
    } else {
      const bool is_taken = live->strand().post([this, live, limit] {
        if (live->idle() < limit || live->isClosed()) return;
        log::info("event=session_expired session={}", live->id());
        closeSession(*live, context_, {}, "idle for " + inWords(limit));
      });
      if (!is_taken) log::debug("event=expiry_waits session={}", live->id());
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
  log::warn(
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

}  // namespace handgraft::server
