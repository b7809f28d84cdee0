#include "idl/cyclone/requester.h"

#include <algorithm>
#include <condition_variable>
#include <map>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "idl/client_id.h"
#include "idl/cyclone/calls.h"
#include "idl/cyclone/known_server.h"
#include "idl/cyclone/requester_wires.h"
#include "idl/operations.h"

namespace handgraft::idl::cyclone {

namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr milliseconds kUnknown(30'000);  // how long an edit's outcome is asked for in silence
constexpr milliseconds kHeldUp(250);      // beyond the time to look: more than a busy machine
constexpr milliseconds kLook(50);         // for calls that a silent server leaves behind
constexpr std::size_t kMiB = 1024 * 1024;
// Ids from the oldest that the server may not have seen to the newest sent: it keeps the
// answers of a client's last 64 requests (server/README), and never begins one that is older
// than a forgotten one.
constexpr std::uint64_t kWindow = 48;
constexpr std::uint64_t kEditWindow = 384;  // likewise, of 512

}  // namespace

struct Requester::Impl {
  explicit Impl(const Participant& on)
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

  ~Impl() {
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
    for (auto* calls : {&edit_calls, &waiting_edits}) {
      while (!calls->empty()) {
        const auto call = calls->extract(calls->begin()).mapped();
        call->on_reply(gone);
      }
    }
  }

  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  Writer<v1::Request>& writerOf(const RequestCall& call) {
    return wires.writerOf(call.message.body()._d());
  }

  Writer<v1::Edit>& writerOf(const EditCall& /*call*/) { return wires.writerOfEdits(); }

  // === Receiving: everything is taken as it comes, so that other clients' replies do not pile
  // up

  void arrived() {
    {
      const std::lock_guard lock(mutex);
      has_data = true;
    }
    something.notify_all();
  }

  /// This program itself stood still, or did not get its turn: what it did not hear then is
  /// nobody's silence. `mutex` held.
  void forgive(Clock::time_point since) {
    const auto held_up = Clock::now() - since - kLook;
    if (held_up > kHeldUp) server.forgive(held_up);
  }

  void receive() {
    std::unique_lock lock(mutex);
    while (!stopping) {
      const bool nothing_asked = request_calls.empty() && edit_calls.empty();
      const auto is_due = [this] {
        return has_data || stopping || !failures.empty();
      };
      if (nothing_asked) {
        something.wait(lock, [&] {
          return is_due() || !request_calls.empty() || !edit_calls.empty();
        });
      } else {
        const Clock::time_point before = Clock::now();
        something.wait_for(lock, kLook, is_due);
        forgive(before);
      }
      if (stopping) return;
      has_data = false;
      lock.unlock();
      takeAll();
      endLostCalls();
      lock.lock();
      news.notify_all();
    }
  }

  void takeAll() {
    wires.statuses().take([this](const v1::ServerStatus& message) {
      const std::lock_guard lock(mutex);
      server.hear(message);
    });
    if (auto* reader = wires.progresses())
      reader->take([this](const v1::Progress& message) {
        if (message.client() != client) return;
        OnProgress tell;
        {
          const std::lock_guard lock(mutex);
          const auto found = request_calls.find(message.request_id());
          if (found == request_calls.end()) return;
          server.hearAnswer();
          found->second->heard = true;
          found->second->pace.slowDown();
          tell = found->second->on_progress;
        }
        if (tell) tell(message.stage(), message.fraction());
      });
    if (auto* reader = wires.replies())
      reader->take([this](const v1::Reply& message) {
        if (message.client() != client || isStrangers(message)) return;
        if (const auto call =
                extract(request_calls, message.request_id(), message.server_id())) {
          call->on_reply(outcomeOf<v1::ReplyBody>(message, message.body()));
        }
      });
    if (auto* reader = wires.editReplies())
      reader->take([this](const v1::EditReply& message) {
        if (message.client() != client || isStrangers(message)) return;
        if (const auto call = extract(edit_calls, message.edit_id(), message.server_id())) {
          call->on_reply(outcomeOf<v1::EditReply>(message, message));
        }
      });
  }

  /// True of the answer of a server that was not asked: it says so to every repeat, and counts
  /// for nothing while the one that was asked may still answer.
  template <class Reply>
  bool isStrangers(const Reply& reply) {
    if (reply.error() != v1::ERROR_OTHER_SERVER) return false;
    const std::lock_guard lock(mutex);
    return !server.isIt(reply.server_id());
  }

  template <class Body, class Reply>
  static Outcome<Body> outcomeOf(const Reply& reply, const Body& body) {
    if (reply.error() == v1::ERROR_NONE) return body;
    return std::make_exception_ptr(Refused(reply.error(), reply.message()));
  }

  /// What was answered, by `server_id`; nullptr if nobody waits for it.
  template <class AnyCall>
  std::shared_ptr<AnyCall> extract(Calls<AnyCall>& calls,
                                   std::uint64_t id,
                                   std::uint64_t server_id = 0) {
    const std::lock_guard lock(mutex);
    const auto found = calls.find(id);
    if (found == calls.end()) return nullptr;
    if (server.isIt(server_id)) server.hearAnswer();
    auto call = calls.extract(found).mapped();
    to_send.notify_all();  // one that waits may go
    return call;
  }

  /// Tells calls whose server is gone, and those that could not be sent.
  void endLostCalls() {
    std::vector<std::function<void()>> ends;
    {
      const std::lock_guard lock(mutex);
      server.succeed();
      ends.swap(failures);
      collectLost(request_calls, ends);
      collectLost(waiting, ends);
      collectLost(edit_calls, ends);
      collectLost(waiting_edits, ends);
    }
    for (const auto& end : ends)
      end();
  }

  template <class AnyCall>
  void collectLost(Calls<AnyCall>& calls, std::vector<std::function<void()>>& ends) {
    for (auto at = calls.begin(); at != calls.end();) {
      const std::exception_ptr lost = lossOf(*at->second, ends);
      if (!lost) {
        ++at;
        continue;
      }
      ends.push_back([call = at->second, lost] {
        call->on_reply(lost);
      });
      at = calls.erase(at);
    }
  }

  // === The server's life; `mutex` held

  /// The server that a call is for: its own, or whichever is there.
  template <class AnyCall>
  [[nodiscard]] std::uint64_t serverOf(const AnyCall& call) const {
    return call.of_one_server || !server.status() ? call.message.server_id()
                                                  : server.status()->server_id();
  }

  /// Why a call can hope for nothing; nullptr if it can.
  std::exception_ptr lossOf(const RequestCall& call,
                            std::vector<std::function<void()>>& /*tell*/) const {
    return server.lossSince(call.begun, serverOf(call), participant);
  }

  /// Likewise. Whether an edit was applied before its server fell silent is not known, and it
  /// may still be once it is heard again: its outcome is asked for until it is known, or until
  /// it is over with that server.
  std::exception_ptr lossOf(EditCall& call, std::vector<std::function<void()>>& tell) const {
    const std::exception_ptr lost = server.lossSince(call.begun, serverOf(call), participant);
    const std::optional<v1::ServerStatus>& status = server.status();
    if (!lost || !status || status->protocol_version() != v1::PROTOCOL_VERSION) return lost;
    if (status->server_id() != call.message.server_id() && call.message.server_id() != 0)
      return lost;
    if (status->stopping() || server.silenceSince(call.begun) >= kUnknown) {
      return std::make_exception_ptr(Refused(
          v1::ERROR_OUTCOME_UNKNOWN,
          fmt::format("handgraft-server on {} {}: whether the edit was applied is not known",
                      describe(participant.network()),
                      status->stopping() ? "is stopping" : "stopped answering")));
    }
    if (!std::exchange(call.silence_told, true) && call.on_progress) {
      tell.push_back([on_progress = call.on_progress] {
        on_progress("no answer, outcome unknown: asking again", 0.0);
      });
    }
    return nullptr;
  }

  // === Sending

  void repeat() {
    std::unique_lock lock(mutex);
    while (!stopping) {
      admit();
      Clock::time_point next = Clock::now() + std::chrono::hours(1);
      const auto request = nextDue(request_calls, next);
      const auto edit = nextDue(edit_calls, next);
      if (!request && !edit) {
        to_send.wait_until(lock, next);
        continue;
      }
      lock.unlock();
      if (request) sendNow(*request);
      if (edit) sendNow(*edit);
      lock.lock();
    }
  }

  /// Lets those go that waited for older ones to be answered.
  void admit() {
    while (!waiting.empty() && mayGo(waiting.begin()->first)) {
      request_calls.insert(waiting.extract(waiting.begin()));
    }
    while (!waiting_edits.empty() && mayEdit(waiting_edits.begin()->first)) {
      edit_calls.insert(waiting_edits.extract(waiting_edits.begin()));
    }
  }

  [[nodiscard]] bool mayGo(std::uint64_t id) const {
    for (const auto& [oldest, call] : request_calls) {
      if (!call->heard) return id < oldest + kWindow;
    }
    return true;
  }

  [[nodiscard]] bool mayEdit(std::uint64_t id) const {
    return edit_calls.empty() || id < edit_calls.begin()->first + kEditWindow;
  }

  /// One whose time has come, else nullptr; `next` becomes the earliest time of another.
  template <class AnyCall>
  static std::shared_ptr<AnyCall> nextDue(const Calls<AnyCall>& calls,
                                          Clock::time_point& next) {
    const Clock::time_point now = Clock::now();
    for (const auto& [id, call] : calls) {
      if (call->pace.next() <= now) {
        call->pace.sent(now);
        return call;
      }
      next = std::min(next, call->pace.next());
    }
    return nullptr;
  }

  void sendNow(RequestCall& call) {
    std::optional<std::uint64_t> cancel_id;
    {
      const std::lock_guard lock(mutex);
      cancel_id = call.cancel_id;
    }
    if (cancel_id) {
      try {
        tryWrite([&] {
          writerOf(call).write(cancelRequest(*cancel_id, call.message));
        });
      } catch (const Refused&) {
        // Nor may what it would cancel, which is told below.
      }
    }
    write(call, request_calls, call.message.request_id());
  }

  void sendNow(EditCall& call) { write(call, edit_calls, call.message.edit_id()); }

  /// A message that cannot be written ends its call, told by the receiver like every outcome.
  template <class AnyCall>
  void write(AnyCall& call, Calls<AnyCall>& calls, std::uint64_t id) {
    std::uint64_t server_id = 0;
    {
      const std::lock_guard lock(mutex);
      server_id = serverOf(call);
    }
    try {
      auto& writer = writerOf(call);
      wires.hearAnswers();
      tryWrite([&] {
        if (server_id == call.message.server_id()) return writer.write(call.message);
        auto readdressed = call.message;
        readdressed.server_id(server_id);
        writer.write(readdressed);
      });
    } catch (const std::exception&) {
      if (const auto mine = extract(calls, id)) {
        fail([mine, error = std::current_exception()] {
          mine->on_reply(error);
        });
      }
    }
  }

  /// A reader that does not keep up is not an error: what is lost now is repeated soon.
  static void tryWrite(const std::function<void()>& write) {
    try {
      write();
    } catch (const WriteTimeout&) {
    }
  }

  void fail(std::function<void()> tell) {
    {
      const std::lock_guard lock(mutex);
      failures.push_back(std::move(tell));
    }
    something.notify_all();
  }

  [[nodiscard]] v1::Request cancelRequest(std::uint64_t id, const v1::Request& of) const {
    v1::Request request;
    request.client(client);
    request.request_id(id);
    request.protocol_version(v1::PROTOCOL_VERSION);
    request.server_id(of.server_id());
    v1::CancelRequest body;
    body.request_id(of.request_id());
    request.body().cancel(body);
    request.body()._d(v1::OP_CANCEL);
    return request;
  }

  Participant participant;
  const v1::ClientId client = randomClient();

  mutable std::mutex mutex;           // guards what follows, down to the writers
  std::condition_variable something;  // for the receiver
  std::condition_variable to_send;    // for the repeater
  std::condition_variable news;       // of the server's life
  bool has_data = false;
  bool stopping = false;
  std::uint64_t next_request = 1;
  std::uint64_t next_edit = 1;
  Calls<RequestCall> request_calls;
  Calls<RequestCall> waiting;  ///< not sent yet
  Calls<EditCall> edit_calls;
  Calls<EditCall> waiting_edits;                ///< likewise
  std::vector<std::function<void()>> failures;  ///< to be told
  KnownServer server;

  // Its listeners touch all of the above: made last, gone first.
  RequesterWires wires;
  std::thread receiver;
  std::thread repeater;
};

Requester::Requester(const Participant& participant)
    : impl_(std::make_unique<Impl>(participant)) {}

Requester::~Requester() = default;

bool Requester::waitForServer(milliseconds timeout) {
  const Clock::time_point deadline = Clock::now() + timeout;
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
  request.request_id(id);
  const auto call =
      std::make_shared<RequestCall>(std::move(request), bytes, std::move(on_reply));
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
  const std::uint64_t id = impl_->next_edit++;
  edit.edit_id(id);
  const std::size_t bytes = v1::EditBody::getCdrSerializedSize(body);
  const auto call = std::make_shared<EditCall>(std::move(edit), bytes, std::move(on_reply));
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
