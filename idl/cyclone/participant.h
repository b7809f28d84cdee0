#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>

#include "idl/topics.h"

namespace handgraft::idl::cyclone {

/// Where to meet: the same two options on every program.
struct Network {
  int domain = 0;                ///< 0-100: higher ones run into ephemeral ports
  std::string interface = "lo";  ///< name of a network interface
};

/// Throws InvalidInput unless the domain lies in 0-100 and the interface exists.
void validate(const Network& network);

/// This process on the bus, by Cyclone DDS. Readers and writers keep it alive.
///
/// Errors: InvalidInput for a bad domain or interface; TransportError if DDS refuses.
/// Threads: all methods are safe from any thread; listeners run on Cyclone's own receive thread and
/// must return at once.
class Participant {
 public:
  explicit Participant(const Network& network);
  ~Participant();

  [[nodiscard]] const Network& network() const;

  struct Impl;
  [[nodiscard]] const std::shared_ptr<Impl>& impl() const { return impl_; }

 private:
  std::shared_ptr<Impl> impl_;
};

/// Publishes messages of one topic. Defined for the message types listed at the end of
/// participant.cpp; another one is one line there.
template <class Message>
class Writer {
 public:
  Writer(const Participant& participant, const Topic<Message>& topic);
  ~Writer();

  /// Errors: TransportError, also for a message that does not fit its IDL bounds.
  void write(const Message& message);

  /// Number of matched readers.
  [[nodiscard]] int readers() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Receives messages of one topic. What does not decode is dropped and counted.
template <class Message>
class Reader {
 public:
  /// `on_data` is called, when given, each time something has arrived; take() it from anywhere.
  Reader(const Participant& participant,
         const Topic<Message>& topic,
         std::function<void()> on_data = {});
  ~Reader();

  /// Hands every message waiting to `use`; returns how many. `use` may throw.
  int take(const std::function<void(const Message&)>& use);

  /// Waits until there is something to take; false when `timeout` passed.
  bool wait(std::chrono::milliseconds timeout);

  /// Number of matched writers.
  [[nodiscard]] int writers() const;
  [[nodiscard]] unsigned rejected() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace handgraft::idl::cyclone
