#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "idl/client_id.h"
#include "idl/cyclone/calls.h"
#include "idl/cyclone/known_server.h"
#include "idl/cyclone/requester_wires.h"
#include "idl/cyclone/window.h"

namespace handgraft::idl::cyclone {

/// What a requester has under way, and the two threads that send it, again and again
/// (exchange_send), and hear what becomes of it (exchange_receive).
struct Requester::Impl {
  using Clock = std::chrono::steady_clock;

  explicit Impl(const Participant& on);
  ~Impl();
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  // === Receiving: everything is taken as it comes

  void arrived();
  /// This program itself stood still, or did not get its turn: what it did not hear then is
  /// nobody's silence. `mutex` held.
  void forgive(Clock::time_point since);
  void receive();
  void takeAll();
  void hear(const v1::Progress& message);
  /// What concerns all that is under way.
  void tellAll(const std::string& news);
  void hear(const v1::Reply& message);
  void hear(const v1::EditReply& message);
  /// True of the answer of a server that was not meant: it says so to every repeat, and counts
  /// for nothing while the one that was meant may still answer, or where the next repeat will
  /// be meant for this one.
  template <class AnyCall, class Reply>
  bool isStrangers(const Calls<AnyCall>& calls, std::uint64_t id, const Reply& reply);
  /// Tells those that could not be sent and, `kLook` after it did so last, calls whose server
  /// is gone.
  void endLostCalls();
  template <class AnyCall>
  void collectLost(Calls<AnyCall>& calls, std::vector<std::function<void()>>& ends);

  /// What was answered, by `server_id`; nullptr if nobody waits for it.
  template <class AnyCall>
  std::shared_ptr<AnyCall> extract(Calls<AnyCall>& calls,
                                   std::uint64_t id,
                                   std::uint64_t server_id = 0) {
    const std::lock_guard lock(mutex);
    const auto found = calls.find(id);
    if (found == calls.end()) return nullptr;
    if (server.isIt(server_id)) {
      server.hearAnswer();
      // What it works on takes its time, which says nothing of the way there.
      if (!found->second->heard) answer_time.add(Clock::now() - found->second->begun);
    }
    auto call = calls.extract(found).mapped();
    to_send.notify_all();  // one that waits may go
    return call;
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
                            std::vector<std::function<void()>>& tell) const;
  /// Likewise. Whether an edit was applied before its server fell silent is not known, and it
  /// may still be once it is heard again: its outcome is asked for until it is known, or until
  /// it is over with that server.
  std::exception_ptr lossOf(EditCall& call, std::vector<std::function<void()>>& tell) const;

  /// Where another server, or the same one after a start, is the one to ask, all that is under
  /// way is said to it at once.
  void sayAnewTo(std::uint64_t start);

  // === Sending

  void repeat();
  /// Lets those go that waited for older ones to be answered.
  void admit();
  [[nodiscard]] bool mayGo(std::uint64_t id) const;
  [[nodiscard]] bool mayEdit(std::uint64_t id) const;
  void sendNow(RequestCall& call);
  void sendNow(EditCall& call);
  /// A message that cannot be written ends its call, told by the receiver like every outcome.
  template <class AnyCall>
  void write(AnyCall& call, Calls<AnyCall>& calls, std::uint64_t id);
  void fail(std::function<void()> tell);
  [[nodiscard]] v1::Request cancelRequest(std::uint64_t id, const v1::Request& of) const;

  Writer<v1::Request>& writerOf(const RequestCall& call) {
    return wires.writerOf(call.message.body()._d());
  }

  Writer<v1::Edit>& writerOf(const EditCall& /*call*/) { return wires.writerOfEdits(); }

  // The server remembers the answers of a client's last 512 edits (server/README), and never
  // begins one that is older than a forgotten one.
  static constexpr std::size_t kMostEdits = 384;

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
  Window edit_window{kMostEdits};               ///< of edits under way
  std::vector<std::function<void()>> failures;  ///< to be told
  Clock::time_point looked;                     ///< for lost calls
  KnownServer server;
  std::uint64_t said_to = 0;  ///< the server's start, as it counts them
  AnswerTime answer_time;

  // Its listeners touch all of the above: made last, gone first.
  RequesterWires wires;
  std::thread receiver;
  std::thread repeater;
};

}  // namespace handgraft::idl::cyclone
