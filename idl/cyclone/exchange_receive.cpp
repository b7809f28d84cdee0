// What comes back: answers, progress, and that nothing will come any more.
#include <optional>
#include <utility>

#include "idl/cyclone/exchange.h"

namespace handgraft::idl::cyclone {

namespace {

using std::chrono::milliseconds;

constexpr milliseconds kUnknown(30'000);  // how long an edit's outcome is asked for in silence
constexpr milliseconds kHeldUp(250);      // beyond the time to look: more than a busy machine
constexpr milliseconds kLook(50);         // for calls that a silent server leaves behind

template <class Body, class Reply>
Requester::Outcome<Body> outcomeOf(const Reply& reply, const Body& body) {
  if (reply.error() == v1::ERROR_NONE) return body;
  return std::make_exception_ptr(Refused(reply.error(), reply.message()));
}

}  // namespace

void Requester::Impl::arrived() {
  {
    const std::lock_guard lock(mutex);
    has_data = true;
  }
  something.notify_all();
}

void Requester::Impl::forgive(Clock::time_point since) {
  const auto held_up = Clock::now() - since - kLook;
  if (held_up > kHeldUp) server.forgive(held_up);
}

void Requester::Impl::receive() {
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

void Requester::Impl::takeAll() {
  wires.statuses().take([this](const v1::ServerStatus& message) {
    const std::lock_guard lock(mutex);
    server.hear(message);
  });
  const auto hear_all = [this](auto* reader) {
    if (reader == nullptr) return;
    reader->take([this](const auto& message) {
      // The server sends to this participant alone, which others may have made requesters on.
      if (message.client() == client) hear(message);
    });
  };
  if (auto* progresses = wires.progresses()) {
    progresses->take([this](const v1::Progress& message) {
      if (message.client() == client) hear(message);
      if (message.client() == v1::ClientId{} && message.request_id() == 0)
        tellAll(message.stage());
    });
  }
  hear_all(wires.replies());
  hear_all(wires.editReplies());
}

void Requester::Impl::tellAll(const std::string& news) {
  std::vector<OnProgress> tell;
  {
    const std::lock_guard lock(mutex);
    const auto add = [&tell](const auto& calls) {
      for (const auto& [id, call] : calls) {
        if (call->on_progress) tell.push_back(call->on_progress);
      }
    };
    add(request_calls);
    add(edit_calls);
  }
  for (const OnProgress& one : tell)
    one(news, 0.0);
}

void Requester::Impl::hear(const v1::Progress& message) {
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
}

template <class AnyCall, class Reply>
bool Requester::Impl::isStrangers(const Calls<AnyCall>& calls,
                                  std::uint64_t id,
                                  const Reply& reply) {
  if (reply.error() != v1::ERROR_OTHER_SERVER) return false;
  const std::lock_guard lock(mutex);
  if (!server.isIt(reply.server_id())) return true;
  const auto found = calls.find(id);
  return found != calls.end() && !found->second->of_one_server;
}

void Requester::Impl::hear(const v1::Reply& message) {
  if (isStrangers(request_calls, message.request_id(), message)) return;
  if (const auto call = extract(request_calls, message.request_id(), message.server_id()))
    call->on_reply(outcomeOf<v1::ReplyBody>(message, message.body()));
}

void Requester::Impl::hear(const v1::EditReply& message) {
  if (isStrangers(edit_calls, message.edit_id(), message)) return;
  const auto call = extract(edit_calls, message.edit_id(), message.server_id());
  if (!call) return;
  {
    const std::lock_guard lock(mutex);
    if (message.error() == v1::ERROR_OVERLOADED)
      edit_window.repeated(Clock::now(), kLook);
    else
      edit_window.answered();
  }
  to_send.notify_all();  // more may go
  call->on_reply(outcomeOf<v1::EditReply>(message, message));
}

template <class AnyCall>
void Requester::Impl::collectLost(Calls<AnyCall>& calls,
                                  std::vector<std::function<void()>>& ends) {
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

void Requester::Impl::endLostCalls() {
  std::vector<std::function<void()>> ends;
  {
    const std::lock_guard lock(mutex);
    server.succeed();
    sayAnewTo(server.start());
    ends.swap(failures);
    const Clock::time_point now = Clock::now();
    if (now - looked >= kLook) {
      looked = now;
      collectLost(request_calls, ends);
      collectLost(waiting, ends);
      collectLost(edit_calls, ends);
      collectLost(waiting_edits, ends);
    }
  }
  for (const auto& end : ends)
    end();
}

void Requester::Impl::sayAnewTo(std::uint64_t start) {
  if (std::exchange(said_to, start) == start) return;
  answer_time.forget();
  for (const auto& [id, call] : request_calls)
    call->pace.beginAnew();
  for (const auto& [id, call] : edit_calls)
    call->pace.beginAnew();
  to_send.notify_all();
}

std::exception_ptr Requester::Impl::lossOf(const RequestCall& call,
                                           std::vector<std::function<void()>>& /*tell*/) const {
  return server.lossSince(call.begun, serverOf(call), participant);
}

std::exception_ptr Requester::Impl::lossOf(EditCall& call,
                                           std::vector<std::function<void()>>& tell) const {
  std::exception_ptr lost = server.lossSince(call.begun, serverOf(call), participant);
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

}  // namespace handgraft::idl::cyclone
