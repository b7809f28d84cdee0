// Requests: admitted once, dispatched to a thread, answered.
#include <utility>

#include <fmt/format.h>

#include "core/base/error.h"
#include "idl/check.h"
#include "idl/operations.h"
#include "server/admission/error_reply.h"
#include "server/admission/service.h"
#include "server/admission/session_rights.h"
#include "server/base/rejection.h"
#include "server/handlers/solving_phase.h"
#include "server/log/log.h"

namespace handgraft::server {

using Clock = std::chrono::steady_clock;

Service::Job::Job(v1::Request what, const Sender& sender, Service& service)
    : request(std::move(what)),
      asker{sender, request.client()},
      progress([this, &service](std::string_view stage, double part) {
        service.tell(*this, stage, part);
      }) {}

template <class Reply>
bool Service::passes(Reply reply, const Sender& sender, const std::function<void()>& check) {
  try {
    check();
    return true;
  } catch (...) {
    ErrorReply error = errorReplyOf(std::current_exception());
    reply.error(error.code);
    reply.message(std::move(error.message));
    reply.server_id(server_id_);
    bus_.publish(reply, sender);
    return false;
  }
}

template bool Service::passes(v1::Reply, const Sender&, const std::function<void()>&);
template bool Service::passes(v1::EditReply, const Sender&, const std::function<void()>&);

void Service::onRequest(v1::Request request, const Sender& sender) {
  v1::Reply reply;
  reply.client(request.client());
  reply.request_id(request.request_id());
  if (!passes(reply, sender, [&] {
        requireMeant(request.server_id());
      }))
    return;
  const auto job = std::make_shared<Job>(std::move(request), sender, *this);
  const auto begun = requests_.begin(job->asker, job->request.request_id());
  switch (begun.verdict) {
    case Requests::Verdict::kRunning:
      return hearAgain({job->asker, job->request.request_id()});
    case Requests::Verdict::kForgotten:
      passes(reply, sender, [&] {
        rejectForgotten("request", reply.request_id());
      });
      return;
    case Requests::Verdict::kAnswered:
      bus_.publishAgain(begun.answer->open(), sender);
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

void Service::hearAgain(const Key& key) {
  const std::lock_guard lock(running_mutex_);
  const auto found = running_.find(key);
  if (found != running_.end()) found->second->heard = Clock::now();
}

Call Service::callOf(const Job& job, LiveSession* live) {
  return {job.request, job.asker.sender, context_, job.progress, live};
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
  for (auto at = running_.lower_bound({RequestOrigin{sender, {}}, 0});
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

void Service::stopSolving(std::uint64_t session_id, const RequestOrigin& stopper) {
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
  log::at(reply.error() == v1::ERROR_NONE ? log::Level::kDebug : log::Level::kInfo,
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
  const PackedReply packed(reply);
  const auto kept = requests_.answer(job.asker, id, packed, bytes);
  if (*kept != packed) reply = kept->open();  // a cancellation that overtook it
  {
    const std::lock_guard lock(running_mutex_);
    running_.erase({job.asker, id});
    running_bytes_ -= job.bytes;
  }
  ++answered_;
  bus_.publish(reply, job.asker.sender);
}

void Service::cancel(const RequestOrigin& asker, std::uint64_t request_id) {
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
  requests_.answer(asker, request_id, PackedReply(reply),
                   v1::Reply::getCdrSerializedSize(reply));
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
  bus_.publish(message, job.asker.sender);
}

}  // namespace handgraft::server
