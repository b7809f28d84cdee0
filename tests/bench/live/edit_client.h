#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "idl/cyclone/participant.h"
#include "idl/cyclone/requester.h"
#include "idl/edits.h"
#include "idl/service.h"

namespace handgraft::bench {

using Clock = std::chrono::steady_clock;

/// What became of an edit, as its client saw it; times since it was published, in ms.
struct EditFate {
  bool answered = false;
  bool solved = false;  ///< a final solution of its revision, or of a later one, came
  v1::ErrorCode error = v1::ERROR_NONE;
  std::string message;
  std::uint64_t revision = 0;
  double reply_ms = 0.0;
  double solution_ms = 0.0;
  double back_ms = 0.0;  ///< of that solution, from its stamp to the client
  std::map<std::string, double> stages_ms;
  bool shared = false;  ///< solved together with a later edit
};

/// An editor of many sessions at once, over Cyclone DDS: publishes edits without waiting and
/// notes when replies and final solutions arrive. Threads: one user; listens on Cyclone's.
class EditClient {
 public:
  explicit EditClient(const Network& network);

  [[nodiscard]] idl::cyclone::Requester& requester() { return requester_; }

  v1::SessionState open(const v1::OpenSessionRequest& request);
  v1::ReplyBody ofSession(v1::Operation operation, std::uint64_t session);

  /// Publishes an edit; its number.
  std::uint64_t send(std::uint64_t session, const v1::EditBody& body);
  /// Waits until an edit is refused, or answered and solved; what is known at the latest after
  /// `timeout`. Repeats nothing: what is lost stays lost, and shows.
  EditFate await(std::uint64_t session, std::uint64_t edit, Clock::duration timeout);

  /// Every edit of a session so far, in order.
  [[nodiscard]] std::vector<EditFate> fates(std::uint64_t session);
  void forget();

 private:
  struct Sent {
    Clock::time_point at;
    EditFate fate;
  };

  /// The last final solution of a session.
  struct Final {
    std::uint64_t revision = 0;
    Clock::time_point at;
    double back_ms = 0.0;
    std::map<std::string, double> stages_ms;
  };

  void takeReplies();
  void takeSolutions();
  /// Notes that `latest` answers an edit, if it does.
  static void takeAnswer(const Final& latest, Sent& sent);

  static bool isOver(const EditFate& fate) {
    return fate.answered && (fate.solved || fate.error != v1::ERROR_NONE);
  }

  idl::cyclone::Participant participant_;
  idl::cyclone::Requester requester_;
  v1::ClientId client_;
  std::uint64_t last_edit_ = 0;
  std::mutex mutex_;
  std::condition_variable news_;
  std::map<std::uint64_t, std::map<std::uint64_t, Sent>> sent_;  ///< by session, by edit
  std::map<std::uint64_t, Final> latest_;                        ///< by session
  idl::cyclone::Writer<v1::Edit> edits_;
  // Their listeners touch all of the above: made last, gone first.
  idl::cyclone::Reader<v1::EditReply> replies_;
  idl::cyclone::Reader<v1::PoseSolution> solutions_;
};

}  // namespace handgraft::bench
