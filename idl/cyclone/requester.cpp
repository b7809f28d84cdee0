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
#include "idl/fields.h"
#include "idl/operations.h"
#include "idl/security/rights.h"

namespace handgraft::idl::cyclone {

namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr milliseconds kFirstAnswer(2000);  // a server that lives says so once a second
constexpr milliseconds kLost(3000);         // three missed, on a machine that may be busy
constexpr milliseconds kUnknown(30'000);  // how long an edit's outcome is asked for in silence
constexpr milliseconds kHeldUp(250);      // beyond the time to look: more than a busy machine
constexpr milliseconds kLook(50);         // for calls that a silent server leaves behind
constexpr std::size_t kMiB = 1024 * 1024;
// Ids from the oldest that the server may not have seen to the newest sent: it keeps the
// answers of a client's last 64 requests (server/README), and never begins one that is older
// than a forgotten one.
constexpr std::uint64_t kWindow = 48;
constexpr std::uint64_t kEditWindow = 384;  // likewise, of 512

constexpr std::size_t kMostOthers = 64;  // servers of other names that are remembered

/// What came over the wire, for a message of one line.
std::string plainName(const std::string& name) {
  constexpr std::size_t kLongest = 64;
  std::string plain = name.substr(0, kLongest);
  std::replace_if(
      plain.begin(), plain.end(),
      [](char c) {
        return c < ' ' || c > '~';
      },
      '?');
  return plain;
}

}  // namespace

struct Requester::Impl {
  explicit Impl(const Participant& on)
      : participant(on),
        requests(participant, kRequestTopic),
        looks(participant, kLookTopic),
        operations(participant, kOperateTopic),
        edits(participant, kEditTopic),
        replies(participant,
                kReplyTopic,
                [this] {
                  arrived();
                }),
        edit_replies(participant,
                     kEditReplyTopic,
                     [this] {
                       arrived();
                     }),
        progresses(participant,
                   kProgressTopic,
                   [this] {
                     arrived();
                   }),
        statuses(participant,
                 kStatusTopic,
                 [this] {
                   arrived();
                 }),
        receiver([this] {
          receive();
        }),
        repeater([this] {
          repeat();
        }) {
    // Soon in an open domain, so that the first request finds all matched; in a secured one
    // once it is known what is asked for: roles differ in what they may write and read.
    if (participant.identity()) return;
    requests.get();
    edits.get();
    hearAnswers();
  }

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

  void hearAnswers() {
    replies.get();
    edit_replies.get();
    progresses.get();
  }

  /// Errors: Refused (ERROR_NOT_PERMITTED).
  Writer<v1::Request>& writerOf(const RequestCall& call) {
    const v1::Operation operation = call.message.body()._d();
    if (!participant.identity()) return requests.get();
    const Privilege privilege = traitsOf(operation).privilege;
    try {
      switch (privilege) {
        case Privilege::kLook:
          return looks.get();
        case Privilege::kEdit:
          return requests.get();
        case Privilege::kOperate:
          break;
      }
      return operations.get();
    } catch (const NotPermitted& error) {
      throw Refused(v1::ERROR_NOT_PERMITTED,
                    fmt::format("{}: request '{}' is for {}", error.what(), nameOf(operation),
                                security::holdersOf(privilege)));
    }
  }

  Writer<v1::Edit>& writerOf(const EditCall& /*call*/) {
    try {
      return edits.get();
    } catch (const NotPermitted& error) {
      throw Refused(v1::ERROR_NOT_PERMITTED,
                    fmt::format("{}: edits are for {}", error.what(),
                                security::holdersOf(Privilege::kEdit)));
    }
  }

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
    const Clock::time_point now = Clock::now();
    const auto held_up = now - since - kLook;
    if (held_up > kHeldUp) seen = std::min(now, seen + held_up);
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
    statuses.take([this](const v1::ServerStatus& message) {
      const std::lock_guard lock(mutex);
      if (message.name() != participant.network().server) {
        others[message.name()] = {message.host(),
                                  message.stopping() ? Clock::time_point{} : Clock::now()};
        if (others.size() > kMostOthers) others.erase(others.begin());
        return;
      }
      if (status && status->server_id() != message.server_id()) {
        // Whoever says that he is a server, too, waits until the one we know is gone.
        if (!message.stopping()) successor.emplace(message, Clock::now());
        return succeed();
      }
      status = message;
      seen = Clock::now();
      succeed();
    });
    if (auto* reader = progresses.made())
      reader->take([this](const v1::Progress& message) {
        if (message.client() != client) return;
        OnProgress tell;
        {
          const std::lock_guard lock(mutex);
          const auto found = request_calls.find(message.request_id());
          if (found == request_calls.end()) return;
          seen = Clock::now();
          found->second->heard = true;
          found->second->pace.slowDown();
          tell = found->second->on_progress;
        }
        if (tell) tell(message.stage(), message.fraction());
      });
    if (auto* reader = replies.made())
      reader->take([this](const v1::Reply& message) {
        if (message.client() != client || isStrangers(message)) return;
        if (const auto call =
                extract(request_calls, message.request_id(), message.server_id())) {
          call->on_reply(outcomeOf<v1::ReplyBody>(message, message.body()));
        }
      });
    if (auto* reader = edit_replies.made())
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
    return !status || reply.server_id() != status->server_id();
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
    if (status && status->server_id() == server_id) seen = Clock::now();
    auto call = calls.extract(found).mapped();
    to_send.notify_all();  // one that waits may go
    return call;
  }

  /// Tells calls whose server is gone, and those that could not be sent.
  void endLostCalls() {
    std::vector<std::function<void()>> ends;
    {
      const std::lock_guard lock(mutex);
      succeed();
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

  [[nodiscard]] bool alive() const {
    return status && !status->stopping() && Clock::now() - seen < kLost;
  }

  /// Another server is the one to ask once the one before is gone.
  void succeed() {
    if (!successor || alive()) return;
    auto [next, heard] = *std::exchange(successor, std::nullopt);
    if (Clock::now() - heard >= kLost) return;
    status = std::move(next);
    seen = heard;
  }

  /// The server that a call is for: its own, or whichever is there.
  template <class AnyCall>
  [[nodiscard]] std::uint64_t serverOf(const AnyCall& call) const {
    return call.of_one_server || !status ? call.message.server_id() : status->server_id();
  }

  void requireSameVersion() const {
    if (!status || status->protocol_version() == v1::PROTOCOL_VERSION) return;
    throw Refused(
        v1::ERROR_VERSION,
        fmt::format("the server ({}) speaks protocol {}, this program speaks {}",
                    status->version(), status->protocol_version(), v1::PROTOCOL_VERSION));
  }

  [[nodiscard]] NoServer noServer() const {
    std::string there;
    for (const auto& [name, other] : others) {
      if (Clock::now() - other.heard > kLost) continue;
      there += fmt::format("{}{} on {}", there.empty() ? "" : ", ",
                           name.empty() ? "one without a name" : "--server " + plainName(name),
                           plainName(other.host));
    }
    std::string text = fmt::format(
        "no handgraft-server{} answers on {}",
        there.empty() || !participant.network().server.empty() ? "" : " without a name",
        describe(participant.network()));
    if (!there.empty()) text += "; there is " + there;
    if (participant.identity()) {
      text +=
          "; one that is open, of another authority, or that knows this identity as revoked "
          "does not";
    } else if (participant.isKeptOut()) {
      text += "; a secured program is there, which takes an identity to meet (--identity)";
    }
    return NoServer(text);
  }

  /// Why a call can hope for nothing; nullptr if it can.
  std::exception_ptr lossOf(const RequestCall& call,
                            std::vector<std::function<void()>>& /*tell*/) const {
    return lossSince(call.begun, serverOf(call));
  }

  /// Likewise. Whether an edit was applied before its server fell silent is not known, and it
  /// may still be once it is heard again: its outcome is asked for until it is known, or until
  /// it is over with that server.
  std::exception_ptr lossOf(EditCall& call, std::vector<std::function<void()>>& tell) const {
    const std::exception_ptr lost = lossSince(call.begun, serverOf(call));
    if (!lost || !status || status->protocol_version() != v1::PROTOCOL_VERSION) return lost;
    if (status->server_id() != call.message.server_id() && call.message.server_id() != 0)
      return lost;
    const auto silence = Clock::now() - std::max(seen, call.begun);
    if (status->stopping() || silence >= kUnknown) {
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

  /// Why a call of that server, or of any (0), begun then, can hope for nothing.
  [[nodiscard]] std::exception_ptr lossSince(Clock::time_point begun,
                                             std::uint64_t server_id) const {
    try {
      requireSameVersion();
      if (server_id != 0 && status && status->server_id() != server_id) {
        throw Refused(
            v1::ERROR_OTHER_SERVER,
            fmt::format("handgraft-server {} on {} is gone, and its sessions with it; "
                        "another one ({}) answers",
                        server_id, describe(participant.network()), status->server_id()));
      }
      if (alive() || Clock::now() - begun < kFirstAnswer) return nullptr;
      if (!status) throw noServer();
      throw NoServer(fmt::format("handgraft-server on {} {}", describe(participant.network()),
                                 status->stopping() ? "is stopping" : "stopped answering"));
    } catch (...) {
      return std::current_exception();
    }
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
      hearAnswers();
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
  std::optional<v1::ServerStatus> status;
  Clock::time_point seen{};
  /// Another server and when it was heard; the one to ask once the first is gone.
  std::optional<std::pair<v1::ServerStatus, Clock::time_point>> successor;

  struct Other {
    std::string host;
    Clock::time_point heard;
  };

  std::map<std::string, Other> others;  ///< servers of other names, for who finds none of this

  Lazy<Writer<v1::Request>> requests;
  Lazy<Writer<v1::Request>> looks;
  Lazy<Writer<v1::Request>> operations;
  Lazy<Writer<v1::Edit>> edits;
  // Their listeners touch all of the above: made last, gone first.
  Lazy<Reader<v1::Reply>> replies;
  Lazy<Reader<v1::EditReply>> edit_replies;
  Lazy<Reader<v1::Progress>> progresses;
  Reader<v1::ServerStatus> statuses;
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
    return impl_->alive();
  });
}

void Requester::requireServer() {
  if (!waitForServer()) throw impl_->noServer();
  const std::lock_guard lock(impl_->mutex);
  impl_->requireSameVersion();
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
  if (impl_->status) request.server_id(impl_->status->server_id());
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
  if (impl_->status) edit.server_id(impl_->status->server_id());
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
  return impl_->status.value_or(v1::ServerStatus());
}

}  // namespace handgraft::idl::cyclone
