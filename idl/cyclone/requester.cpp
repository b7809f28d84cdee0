#include "idl/cyclone/requester.h"

#include <chrono>
#include <mutex>
#include <utility>
#include <vector>

#include "idl/cyclone/exchange.h"
#include "idl/operations.h"

namespace handgraft::idl::cyclone {

namespace {

using std::chrono::milliseconds;

constexpr std::size_t kMiB = 1024UL * 1024;
// Of requests, and of edits, that wait to be sent for the first time; more are refused.
constexpr std::size_t kMostWaiting = 10'000;

std::exception_ptr tooMany(const char* what) {
  return std::make_exception_ptr(Refused(
      v1::ERROR_OVERLOADED,
      fmt::format("not sent: {} {} of this program wait already until the server has answered "
                  "earlier ones",
                  kMostWaiting, what)));
}

}  // namespace

Requester::Impl::Impl(const Participant& on)
    : participant(on),
      server(on.network().server),
      wires(participant,
            [this] {
              arrived();
            }),
      receiver([this] {
        receive();
      }),
      repeater([this] {
        repeat();
      }) {}

Requester::Impl::~Impl() {
  {
    const std::lock_guard lock(mutex);
    stopping = true;
  }
  something.notify_all();
  to_send.notify_all();
  receiver.join();
  repeater.join();
  for (const auto& tell : failures)
    tell();
  const auto gone = std::make_exception_ptr(NoServer("the connection was closed"));
  while (!request_calls.empty() || !waiting.empty()) {
    const auto call =
        request_calls.empty() ? waiting.begin()->second : request_calls.begin()->second;
    request_calls.erase(call->message.request_id());
    waiting.erase(call->message.request_id());
    call->on_reply(gone);
  }
  // A server that comes back may have done what was sent, or may do it yet.
  const auto unknown = std::make_exception_ptr(
      Refused(v1::ERROR_OUTCOME_UNKNOWN,
              "the connection was closed: whether the edit was applied is not known"));
  for (const auto& [calls, why] :
       {std::pair(&edit_calls, unknown), std::pair(&waiting_edits, gone)}) {
    while (!calls->empty()) {
      const auto call = calls->extract(calls->begin()).mapped();
      call->on_reply(why);
    }
  }
}

Requester::Requester(const Participant& participant)
    : impl_(std::make_unique<Impl>(participant)) {}

Requester::~Requester() = default;

bool Requester::waitForServer(milliseconds timeout) {
  const auto deadline = Impl::Clock::now() + timeout;
  std::unique_lock lock(impl_->mutex);
  return impl_->news.wait_until(lock, deadline, [this] {
    return impl_->server.isAlive();
  });
}

void Requester::requireServer() {
  const bool is_there = waitForServer();
  const std::lock_guard lock(impl_->mutex);
  if (!is_there) throw impl_->server.none(impl_->participant);
  impl_->server.requireSameVersion();
}

Requester::CallId Requester::begin(const v1::RequestBody& body,
                                   OnReply on_reply,
                                   OnProgress on_progress) {
  v1::Request request;
  request.client(impl_->client);
  request.protocol_version(v1::PROTOCOL_VERSION);
  request.body(body);
  const std::size_t bytes = v1::Request::getCdrSerializedSize(request);
  std::unique_lock lock(impl_->mutex);
  if (impl_->server.status()) request.server_id(impl_->server.status()->server_id());
  const CallId id = impl_->next_request++;
  if (bytes > kLargestRequest) {
    // The server would drop it, and it would be repeated in silence.
    lock.unlock();
    impl_->fail([on_reply = std::move(on_reply), bytes] {
      on_reply(std::make_exception_ptr(TransportError(
          fmt::format("this would be a request of {:.1f} MiB; the server takes "
                      "at most {} MiB",
                      static_cast<double>(bytes) / kMiB, kLargestRequest / kMiB))));
    });
    return id;
  }
  if (impl_->waiting.size() >= kMostWaiting) {
    lock.unlock();
    impl_->fail([on_reply = std::move(on_reply)] {
      on_reply(tooMany("requests"));
    });
    return id;
  }
  request.request_id(id);
  const auto call = std::make_shared<RequestCall>(
      std::move(request), Pace(bytes, impl_->answer_time.lateAfter()), std::move(on_reply));
  call->on_progress = std::move(on_progress);
  call->of_one_server = traitsOf(body._d()).answered_by == AnsweredBy::kOneServer;
  if (!impl_->waiting.empty() || !impl_->mayGo(id)) {
    impl_->waiting.emplace(id, call);
    return id;
  }
  call->pace.sent(call->begun);
  impl_->request_calls.emplace(id, call);
  lock.unlock();
  impl_->sendNow(*call);
  impl_->something.notify_all();
  impl_->to_send.notify_all();
  return id;
}

void Requester::beginEdit(std::uint64_t session_id,
                          std::uint64_t base_revision,
                          const v1::EditBody& body,
                          OnEditReply on_reply,
                          OnProgress on_progress,
                          const std::optional<v1::EditTime>& when) {
  v1::Edit edit;
  edit.client(impl_->client);
  edit.session_id(session_id);
  edit.base_revision(base_revision);
  if (when) edit.when().push_back(*when);
  edit.body(body);
  std::unique_lock lock(impl_->mutex);
  if (impl_->server.status()) edit.server_id(impl_->server.status()->server_id());
  if (impl_->waiting_edits.size() >= kMostWaiting) {
    lock.unlock();
    return impl_->fail([on_reply = std::move(on_reply)] {
      on_reply(tooMany("edits"));
    });
  }
  const std::uint64_t id = impl_->next_edit++;
  edit.edit_id(id);
  const std::size_t bytes = v1::EditBody::getCdrSerializedSize(body);
  const auto call = std::make_shared<EditCall>(
      std::move(edit), Pace(bytes, impl_->answer_time.lateAfter()), std::move(on_reply));
  call->on_progress = std::move(on_progress);
  if (!impl_->waiting_edits.empty() || !impl_->mayEdit(id)) {
    impl_->waiting_edits.emplace(id, call);
    return;
  }
  call->pace.sent(call->begun);
  impl_->edit_calls.emplace(id, call);
  lock.unlock();
  impl_->sendNow(*call);
  impl_->something.notify_all();
  impl_->to_send.notify_all();
}

void Requester::cancel(CallId id) {
  {
    const std::lock_guard lock(impl_->mutex);
    const auto found = impl_->request_calls.find(id);
    if (found == impl_->request_calls.end()) {
      // One that was not sent is sent and cancelled; that is rare, and every outcome has one
      // way.
      const auto unsent = impl_->waiting.find(id);
      if (unsent == impl_->waiting.end() || unsent->second->cancel_id) return;
      unsent->second->cancel_id = impl_->next_request++;
      return;
    }
    RequestCall& call = *found->second;
    if (call.cancel_id) return;
    call.cancel_id = impl_->next_request++;
    call.pace.hurry();
  }
  impl_->to_send.notify_all();
}

void Requester::cancel() {
  std::vector<CallId> ids;
  {
    const std::lock_guard lock(impl_->mutex);
    for (const auto* calls : {&impl_->request_calls, &impl_->waiting}) {
      for (const auto& [id, call] : *calls)
        ids.push_back(id);
    }
  }
  for (const CallId id : ids)
    cancel(id);
}

v1::ReplyBody Requester::ask(const v1::RequestBody& body, const OnProgress& on_progress) {
  const auto awaited = std::make_shared<Awaited<v1::ReplyBody>>();
  begin(
      body,
      [awaited](Outcome<v1::ReplyBody> outcome) {
        awaited->settle(std::move(outcome));
      },
      [awaited](const std::string& stage, double fraction) {
        {
          const std::lock_guard lock(awaited->mutex);
          awaited->progress.emplace(stage, fraction);
        }
        awaited->news.notify_all();
      });
  return awaited->await(on_progress);
}

v1::EditReply Requester::edit(std::uint64_t session_id,
                              std::uint64_t base_revision,
                              const v1::EditBody& body) {
  const auto awaited = std::make_shared<Awaited<v1::EditReply>>();
  beginEdit(session_id, base_revision, body, [awaited](Outcome<v1::EditReply> outcome) {
    awaited->settle(std::move(outcome));
  });
  return awaited->await({});
}

v1::ClientId Requester::client() const {
  return impl_->client;
}

v1::ServerStatus Requester::status() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->server.status().value_or(v1::ServerStatus());
}

}  // namespace handgraft::idl::cyclone
