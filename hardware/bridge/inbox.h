#pragma once

#include <atomic>
#include <functional>
#include <memory>

#include "hardware/bridge/wake_event.h"
#include "idl/cyclone/participant.h"

namespace handgraft::bridge {

/// A reader that rings when something comes, and is looked into only then: asking DDS costs
/// some microseconds, and a bridge has forty readers. Threads: one.
template <class Message>
class Inbox {
 public:
  /// `bell`: none to be taken from now and then.
  Inbox(const idl::cyclone::Participant& participant,
        const idl::Topic<Message>& topic,
        const std::shared_ptr<WakeEvent>& bell)
      : has_come_(std::make_shared<std::atomic<bool>>(true)),
        reader_(participant, topic, [has_come = has_come_, bell] {
          *has_come = true;
          if (bell) bell->ring();
        }) {}

  /// Hands over what came; how many. Errors: as of `use`; the rest comes at the next call.
  int take(const std::function<void(const Message&)>& use) {
    return takeWithOrigin([&use](const Message& message, const idl::cyclone::Origin&) {
      use(message);
    });
  }

  /// The same with where each comes from.
  int takeWithOrigin(
      const std::function<void(const Message&, const idl::cyclone::Origin&)>& use) {
    if (!has_come_->exchange(false)) return 0;
    try {
      return reader_.takeWithOrigin(use);
    } catch (...) {
      *has_come_ = true;
      throw;
    }
  }

 private:
  std::shared_ptr<std::atomic<bool>> has_come_;
  idl::cyclone::Reader<Message> reader_;
};

}  // namespace handgraft::bridge
