#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "server/transport/bus.h"

namespace handgraft::test {

/// A bus without wires: keeps what the service publishes, and lets a test speak as a client.
class RecordingBus final : public server::Bus {
 public:
  void start(server::BusListener& listener) override { listener_ = &listener; }

  void stop() override {}

  void flush() override {}

  [[nodiscard]] std::optional<idl::security::Named> whoIs(
      const server::Sender& sender) const override {
    if (people.empty()) return std::nullopt;
    const auto found = people.find(sender[0]);
    return found == people.end() ? idl::security::Named() : found->second;
  }

  /// Of a secured domain, by the first byte of their participants; empty: an open one.
  std::map<std::uint8_t, idl::security::Named> people;

  void publish(const v1::Reply& one, const server::Sender& /*whom*/) override {
    keep(replies, one);
  }

  void publish(const v1::Progress& one, const server::Sender& /*whom*/) override {
    keep(progress, one);
  }

  void publish(const v1::EditReply& one, const server::Sender& /*whom*/) override {
    keep(edit_replies, one);
  }

  void publish(const v1::ServerStatus& one) override { keep(statuses, one); }

  void publish(const v1::PoseSolution& one) override { keep(solutions, one); }

  void publish(const v1::SessionState& one) override { keep(states, one); }

  void publish(const v1::MotionFrames& one) override { keep(frames, one); }

  void publish(const v1::MotionClock& one) override { keep(clocks, one); }

  void publishJointCommand(std::uint64_t,
                           const sensor_msgs::msg::dds_::JointState_& one) override {
    keep(commands, one);
  }

  /// `sender`: the participant that it comes from.
  void send(std::uint64_t id,
            const v1::RequestBody& body,
            std::uint8_t client = 1,
            std::uint8_t sender = 0) {
    v1::Request request;
    request.client({client});
    request.request_id(id);
    request.protocol_version(v1::PROTOCOL_VERSION);
    request.body(body);
    listener_->onRequest(request, {sender == 0 ? client : sender});
  }

  void hear(const v1::ServerStatus& status) { listener_->onStatus(status); }

  void send(const v1::Request& request) {
    listener_->onRequest(request, {request.client()[0]});
  }

  void send(const v1::DemonstratorFrame& frame) {
    listener_->onDemonstrator(frame, {frame.client()[0]});
  }

  void send(const v1::Edit& edit) { listener_->onEdit(edit, {edit.client()[0]}); }

  /// The first message of `list` that `fits`, waited for.
  template <class Message>
  std::optional<Message> await(const std::vector<Message>& list,
                               const std::function<bool(const Message&)>& fits) {
    std::optional<Message> found;
    std::unique_lock lock(mutex_);
    news_.wait_for(lock, std::chrono::seconds(120), [&] {
      for (const Message& one : list) {
        if (!fits(one)) continue;
        found = one;
        return true;
      }
      return false;
    });
    return found;
  }

  /// Sends and waits for the reply; an empty one with ERROR_INTERNAL if none came.
  v1::Reply ask(const v1::RequestBody& body, std::uint8_t client = 1) {
    const std::uint64_t id = ++last_id_;
    send(id, body, client);
    const auto reply = await<v1::Reply>(replies, [&](const v1::Reply& one) {
      return one.request_id() == id && one.client()[0] == client;
    });
    if (reply) return *reply;
    v1::Reply none;
    none.error(v1::ERROR_INTERNAL);
    none.message("no reply came");
    return none;
  }

  template <class Message>
  std::size_t count(const std::vector<Message>& list) {
    const std::lock_guard lock(mutex_);
    return list.size();
  }

  /// A copy that nothing is added to.
  template <class Message>
  std::vector<Message> copyOf(const std::vector<Message>& list) {
    const std::lock_guard lock(mutex_);
    return list;
  }

  std::size_t countDistinctReplies() {
    std::set<std::pair<v1::ClientId, std::uint64_t>> keys;
    for (const v1::Reply& one : copyOf(replies))
      keys.insert({one.client(), one.request_id()});
    return keys.size();
  }

  std::vector<v1::Reply> replies;
  std::vector<v1::Progress> progress;
  std::vector<v1::EditReply> edit_replies;
  std::vector<v1::ServerStatus> statuses;
  std::vector<v1::PoseSolution> solutions;
  std::vector<v1::SessionState> states;
  std::vector<v1::MotionFrames> frames;
  std::vector<v1::MotionClock> clocks;
  std::vector<sensor_msgs::msg::dds_::JointState_> commands;

 private:
  template <class Message>
  void keep(std::vector<Message>& list, const Message& one) {
    {
      const std::lock_guard lock(mutex_);
      list.push_back(one);
    }
    news_.notify_all();
  }

  server::BusListener* listener_ = nullptr;
  std::uint64_t last_id_ = 1000;
  std::mutex mutex_;
  std::condition_variable news_;
};

}  // namespace handgraft::test
