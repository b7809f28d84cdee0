#pragma once

#include <condition_variable>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "idl/cyclone/pace.h"
#include "idl/cyclone/requester.h"

/// What a requester has under way.
namespace handgraft::idl::cyclone {

/// A request or an edit under way. What is sent does not change; the rest is guarded by the
/// requester's mutex.
template <class Message, class OnReply>
struct Call {
  Call(Message what, Pace when, OnReply done)
      : message(std::move(what)), pace(when), on_reply(std::move(done)) {}

  const Message message;
  const Pace::Clock::time_point begun = Pace::Clock::now();
  Pace pace;
  OnReply on_reply;
  Requester::OnProgress on_progress;
  bool of_one_server = true;               ///< of `message.server_id()`, which stays
  bool heard = false;                      ///< the server is known to be at work on it
  bool silence_told = false;               ///< and its outcome is not known
  std::optional<std::uint64_t> cancel_id;  ///< of the request to cancel it
};

using RequestCall = Call<v1::Request, Requester::OnReply>;
using EditCall = Call<v1::Edit, Requester::OnEditReply>;
template <class AnyCall>
using Calls = std::map<std::uint64_t, std::shared_ptr<AnyCall>>;

/// A wait for one outcome on another thread.
template <class Reply>
struct Awaited {
  std::mutex mutex;
  std::condition_variable news;
  std::optional<Requester::Outcome<Reply>> outcome;
  std::optional<std::pair<std::string, double>> progress;

  void settle(Requester::Outcome<Reply> what) {
    {
      const std::lock_guard lock(mutex);
      outcome = std::move(what);
    }
    news.notify_all();
  }

  Reply await(const Requester::OnProgress& on_progress) {
    std::unique_lock lock(mutex);
    while (true) {
      news.wait(lock, [this] {
        return outcome || progress;
      });
      if (progress && on_progress) {
        const auto [stage, fraction] = *progress;
        progress.reset();
        lock.unlock();
        on_progress(stage, fraction);
        lock.lock();
        continue;
      }
      progress.reset();
      if (!outcome) continue;
      if (auto* error = std::get_if<std::exception_ptr>(&*outcome)) {
        std::rethrow_exception(*error);
      }
      return std::get<Reply>(std::move(*outcome));
    }
  }
};

}  // namespace handgraft::idl::cyclone
