#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>

#include "core/base/error.h"
#include "core/base/network.h"
#include "idl/cyclone/domain.h"
#include "idl/security/identity.h"
#include "idl/topics.h"

namespace handgraft::idl::cyclone {

// Where to meet is the same for every program, whatever vendor carries it.
using handgraft::describe;
using handgraft::Network;
using handgraft::validate;

/// This process on the bus, by Cyclone DDS. Readers and writers keep it alive.
///
/// Errors: InvalidInput for a bad domain or interface, or an identity that is not fit for use
/// (security::readIdentity); TransportError if DDS refuses.
/// Threads: all methods are safe from any thread; listeners run on Cyclone's own receive thread
/// and must return at once.
///
/// Discovery: on loopback by unicast to every participant of the machine (at most 100),
/// elsewhere by multicast. CYCLONEDDS_URI is not read: the two options are the whole
/// configuration. All participants of one process and domain share one interface (InvalidInput
/// otherwise).
class Participant {
 public:
  explicit Participant(const Network& network, Discovers discovers = Discovers::kAll);
  ~Participant();

  [[nodiscard]] const Network& network() const;

  /// Who this is; who has an identity meets others with one alone. Nothing: in an open domain.
  [[nodiscard]] const std::optional<security::Identity>& identity() const;

  /// True once a program of a secured domain was met that this one, without an identity, is
  /// not let in to.
  [[nodiscard]] bool isKeptOut() const;

  /// Cyclone's own, for this folder.
  [[nodiscard]] std::int32_t handle() const;

  struct Impl;

  [[nodiscard]] const std::shared_ptr<Impl>& impl() const { return impl_; }

 private:
  std::shared_ptr<Impl> impl_;
};

/// A reliable reader did not take what was written before within the time allowed; writing
/// again later may succeed.
class WriteTimeout : public TransportError {
 public:
  using TransportError::TransportError;
};

/// The role of this program's identity lacks a right; DDS would refuse at the other end, too.
class NotPermitted : public TransportError {
 public:
  using TransportError::TransportError;
};

/// Publishes messages of one topic. Defined for the message types listed at the end of
/// participant.cpp; another one is one line there.
template <class Message>
class Writer {
 public:
  Writer(const Participant& participant, const Topic<Message>& topic);
  ~Writer();

  /// Errors: WriteTimeout after 1 s; TransportError for everything else, also for a message
  /// that does not fit its IDL bounds (a sequence too long, an enumerator that does not exist).
  void write(const Message& message);

  /// Number of matched readers.
  [[nodiscard]] int readers() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Where a message comes from.
struct Origin {
  std::int64_t written_ns = 0;  ///< by its writer's system clock
  std::uint64_t writer = 0;     ///< tells the writers of one reader apart
};

/// Receives messages of one topic. What does not decode is dropped and counted.
template <class Message>
class Reader {
 public:
  /// `on_data` is called, when given, each time something has arrived; take() it from anywhere.
  /// It runs on Cyclone's receive thread and must not throw.
  Reader(const Participant& participant,
         const Topic<Message>& topic,
         std::function<void()> on_data = {});
  ~Reader();

  /// Hands every message waiting to `use`; returns how many. `use` may throw.
  int take(const std::function<void(const Message&)>& use);

  /// The same with where each comes from.
  int takeWithOrigin(const std::function<void(const Message&, const Origin&)>& use);

  /// Waits until there is something to take; false when `timeout` passed.
  bool wait(std::chrono::milliseconds timeout);

  /// Number of matched writers.
  [[nodiscard]] int writers() const;
  [[nodiscard]] unsigned rejected() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// A writer or reader that is made when it is first used: Cyclone makes no topic that the role
/// of this program's identity may not write or read. Threads: all methods from any thread.
template <class Endpoint>
class Lazy {
 public:
  template <class Message>
  Lazy(const Participant& participant,
       const Topic<Message>& topic,
       std::function<void()> on_data = {})
      : make_([participant, topic, on_data = std::move(on_data)] {
          if constexpr (std::is_same_v<Endpoint, Reader<Message>>) {
            return std::make_unique<Endpoint>(participant, topic, on_data);
          } else {
            return std::make_unique<Endpoint>(participant, topic);
          }
        }) {}

  /// Makes it if need be. Errors: NotPermitted, TransportError.
  Endpoint& get() {
    const std::lock_guard lock(mutex_);
    if (endpoint_ == nullptr) endpoint_ = make_();
    return *endpoint_;
  }

  /// Null before it was made.
  [[nodiscard]] Endpoint* made() const {
    const std::lock_guard lock(mutex_);
    return endpoint_.get();
  }

 private:
  mutable std::mutex mutex_;
  std::function<std::unique_ptr<Endpoint>()> make_;
  std::unique_ptr<Endpoint> endpoint_;
};

}  // namespace handgraft::idl::cyclone
