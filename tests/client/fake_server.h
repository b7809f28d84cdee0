#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <mutex>
#include <thread>
#include <vector>

#include "idl/cyclone/participant.h"
#include "idl/service.h"

namespace handgraft::test {

/// A server that answers as a test tells it to. Repeats of a request get the first answer
/// again, as from a real one.
class FakeServer {
 public:
  /// Fills `reply`'s body, or its error and message. Returning false: no answer yet; the next
  /// repeat asks again.
  using Answer = std::function<bool(const v1::Request& request, v1::Reply& reply)>;

  FakeServer(const Network& network, Answer answer)
      : answer_(std::move(answer)),
        participant_(network),
        requests_(participant_, idl::kRequestTopic),
        replies_(participant_, idl::kReplyTopic),
        statuses_(participant_, idl::kStatusTopic),
        thread_([this] {
          serve();
        }) {}

  ~FakeServer() {
    stopping_ = true;
    thread_.join();
  }

  FakeServer(const FakeServer&) = delete;
  FakeServer& operator=(const FakeServer&) = delete;

  /// Operations in the order in which they came, each request once.
  [[nodiscard]] std::vector<v1::Operation> operations() const {
    const std::lock_guard lock(mutex_);
    return operations_;
  }

 private:
  using Key = std::pair<v1::ClientId, std::uint64_t>;  // each client counts for itself

  void serve() {
    auto next_status = std::chrono::steady_clock::now();
    while (!stopping_) {
      if (std::chrono::steady_clock::now() >= next_status) {
        next_status += std::chrono::milliseconds(500);
        v1::ServerStatus status;
        status.server_id(1);
        status.protocol_version(v1::PROTOCOL_VERSION);
        status.version("fake");
        statuses_.write(status);
      }
      requests_.take([this](const v1::Request& request) {
        answer(request);
      });
      requests_.wait(std::chrono::milliseconds(5));
    }
  }

  void answer(const v1::Request& request) {
    const Key key(request.client(), request.request_id());
    const auto known = replies_sent_.find(key);
    if (known == replies_sent_.end()) {
      v1::Reply reply;
      reply.client(request.client());
      reply.request_id(request.request_id());
      reply.body().nothing(v1::Nothing());
      reply.body()._d(v1::OP_NOTHING);
      if (!answer_(request, reply)) return;
      const std::lock_guard lock(mutex_);
      operations_.push_back(request.body()._d());
      replies_sent_[key] = reply;
    }
    replies_.write(replies_sent_.at(key));
  }

  Answer answer_;
  idl::cyclone::Participant participant_;
  idl::cyclone::Reader<v1::Request> requests_;
  idl::cyclone::Writer<v1::Reply> replies_;
  idl::cyclone::Writer<v1::ServerStatus> statuses_;
  std::map<Key, v1::Reply> replies_sent_;
  mutable std::mutex mutex_;
  std::vector<v1::Operation> operations_;
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

}  // namespace handgraft::test
