#pragma once

#include <condition_variable>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "idl/cyclone/requester.h"
#include "idl/models.h"

namespace handgraft::bridge {

/// A hand that a session asked for and that the server must describe first.
struct HandQuestion {
  std::uint64_t session_id = 0;
  std::string hand;

  bool operator==(const HandQuestion&) const = default;
};

/// Asks the server to describe hands on a thread of its own, since the bridge's loop never
/// waits. A server that does not answer is asked again for as long as the question stands.
///
/// Threads: all methods from one thread, the bridge's.
class HandDescriber {
 public:
  struct Answer {
    HandQuestion question;
    std::optional<v1::HandDescription> description;  ///< absent: refused
    std::string refusal;
  };

  explicit HandDescriber(const idl::cyclone::Participant& participant);
  /// Waits for a request under way: up to 3 s if the server has just died.
  ~HandDescriber();
  HandDescriber(const HandDescriber&) = delete;
  HandDescriber& operator=(const HandDescriber&) = delete;

  /// The question that stands now; the same one again, after its answer, is not asked again
  /// until another question or none stood in between.
  void want(const std::optional<HandQuestion>& question);

  /// The answer to what was wanted, once.
  std::optional<Answer> take();

 private:
  void work();
  Answer ask(const HandQuestion& question);

  idl::cyclone::Requester requester_;
  std::mutex mutex_;
  std::condition_variable changed_;
  bool stopping_ = false;
  bool is_new_ = false;  // the wanted question has not been asked yet
  std::optional<HandQuestion> wanted_;
  std::optional<Answer> answer_;
  std::thread worker_;
};

}  // namespace handgraft::bridge
