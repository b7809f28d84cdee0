// What goes out: at once, and again until it is answered.
#include <algorithm>
#include <optional>
#include <utility>

#include "idl/cyclone/exchange.h"

namespace handgraft::idl::cyclone {

namespace {

// Ids from the oldest that the server may not have seen to the newest sent: it keeps the
// answers of a client's last 64 requests (server/README), and never begins one that is older
// than a forgotten one.
constexpr std::uint64_t kWindow = 48;

/// One of the `most` oldest whose time has come, else nullptr; `next` becomes the earliest time
/// of another.
template <class AnyCall>
std::shared_ptr<AnyCall> nextDue(const Calls<AnyCall>& calls,
                                 std::size_t most,
                                 Pace::Clock::time_point& next) {
  const Pace::Clock::time_point now = Pace::Clock::now();
  for (const auto& [id, call] : calls) {
    if (most-- == 0) break;
    if (call->pace.next() <= now) {
      call->pace.sent(now);
      return call;
    }
    next = std::min(next, call->pace.next());
  }
  return nullptr;
}

/// A reader that does not keep up is not an error: what is lost now is repeated soon.
void tryWrite(const std::function<void()>& write) {
  try {
    write();
  } catch (const WriteTimeout&) {
  }
}

}  // namespace

void Requester::Impl::repeat() {
  std::unique_lock lock(mutex);
  while (!stopping) {
    admit();
    Clock::time_point next = Clock::now() + std::chrono::hours(1);
    const auto request = nextDue(request_calls, request_calls.size(), next);
    const auto edit = nextDue(edit_calls, edit_window.size(), next);
    if (edit && edit->pace.isRepeat())
      edit_window.repeated(Clock::now(), edit->pace.interval());
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

void Requester::Impl::admit() {
  while (!waiting.empty() && mayGo(waiting.begin()->first)) {
    request_calls.insert(waiting.extract(waiting.begin()));
  }
  while (!waiting_edits.empty() && mayEdit(waiting_edits.begin()->first)) {
    edit_calls.insert(waiting_edits.extract(waiting_edits.begin()));
  }
}

bool Requester::Impl::mayGo(std::uint64_t id) const {
  for (const auto& [oldest, call] : request_calls) {
    if (!call->heard) return id < oldest + kWindow;
  }
  return true;
}

bool Requester::Impl::mayEdit(std::uint64_t id) const {
  return edit_calls.empty() || id < edit_calls.begin()->first + edit_window.size();
}

template <class AnyCall>
void Requester::Impl::write(AnyCall& call, Calls<AnyCall>& calls, std::uint64_t id) {
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

void Requester::Impl::sendNow(RequestCall& call) {
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

void Requester::Impl::sendNow(EditCall& call) {
  write(call, edit_calls, call.message.edit_id());
}

void Requester::Impl::fail(std::function<void()> tell) {
  {
    const std::lock_guard lock(mutex);
    failures.push_back(std::move(tell));
  }
  something.notify_all();
}

v1::Request Requester::Impl::cancelRequest(std::uint64_t id, const v1::Request& of) const {
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

}  // namespace handgraft::idl::cyclone
