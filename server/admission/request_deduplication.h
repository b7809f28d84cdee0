#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <utility>

namespace handgraft::server {

/// How much is remembered.
struct DeduplicationLimits {
  std::size_t answers_per_client = 64;
  std::size_t bytes_per_client = 32u << 20;
  std::size_t bytes = 256u << 20;
  std::size_t clients = 4096;  ///< also those whose answers are forgotten
};

/// Which requests of which client were begun and answered, so that a repeat never does work
/// twice.
///
/// An id is `begin`-ed once; while it runs, repeats are to be ignored; once answered, repeats
/// get the same answer. Memory is bounded: the oldest answers are forgotten first, never a
/// client's newest one; an id at or below a forgotten one is never begun again. A client that
/// has been silent longest is forgotten as a whole when there are more than `clients`.
///
/// Threads: all methods from any thread. Cost: O(log n).
/// `RequestOrigin`: what tells one client from another.
template <class Answer, class RequestOrigin = std::array<std::uint8_t, 16>>
class RequestDeduplication {
 public:
  using ClientId = RequestOrigin;

  enum class Verdict {
    kNew,       ///< do it, then `answer`
    kRunning,   ///< it is being done
    kAnswered,  ///< say `answer` again
    kForgotten  ///< begun long ago; what came of it is not known any more
  };

  struct Begun {
    Verdict verdict;
    std::shared_ptr<const Answer> answer;  ///< of kAnswered
  };

  explicit RequestDeduplication(DeduplicationLimits limits = {}) : limits_(limits) {}

  Begun begin(const ClientId& id, std::uint64_t request) {
    const std::lock_guard lock(mutex_);
    Client& client = touch(id);
    if (const auto found = client.answers.find(request); found != client.answers.end()) {
      return {Verdict::kAnswered, found->second.answer};
    }
    if (client.running.count(request) != 0) return {Verdict::kRunning, nullptr};
    if (request <= client.forgotten) return {Verdict::kForgotten, nullptr};
    client.running.insert(request);
    return {Verdict::kNew, nullptr};
  }

  /// Keeps the answer of a request, begun or not; `bytes` is its size. The first answer stands:
  /// what is returned is the one to send.
  std::shared_ptr<const Answer> answer(const ClientId& id,
                                       std::uint64_t request,
                                       Answer answer,
                                       std::size_t bytes) {
    const std::lock_guard lock(mutex_);
    Client& client = touch(id);
    client.running.erase(request);
    const auto [at, fresh] = client.answers.try_emplace(request);
    if (!fresh) return at->second.answer;
    auto kept = std::make_shared<const Answer>(std::move(answer));
    at->second = {kept, bytes};
    client.bytes += bytes;
    bytes_ += bytes;
    trim(client, request);
    trimAll(id);
    return kept;
  }

  /// Gives back the answers of clients that have asked nothing for so long: who still waited
  /// would have repeated its request. That they were begun is still known.
  void forgetSilent(std::chrono::steady_clock::duration silent) {
    const auto now = std::chrono::steady_clock::now();
    const std::lock_guard lock(mutex_);
    for (const ClientId& id : ages_) {
      Client& client = clients_.at(id);
      if (now - client.touched < silent) return;
      while (!client.answers.empty())
        forget(client, client.answers.begin());
    }
  }

  [[nodiscard]] bool running(const ClientId& id, std::uint64_t request) const {
    const std::lock_guard lock(mutex_);
    const auto found = clients_.find(id);
    return found != clients_.end() && found->second.running.count(request) != 0;
  }

  /// Bytes of all answers kept.
  [[nodiscard]] std::size_t bytes() const {
    const std::lock_guard lock(mutex_);
    return bytes_;
  }

  [[nodiscard]] std::size_t clientCount() const {
    const std::lock_guard lock(mutex_);
    return clients_.size();
  }

 private:
  struct Kept {
    std::shared_ptr<const Answer> answer;
    std::size_t bytes = 0;
  };

  struct Client {
    std::map<std::uint64_t, Kept> answers;
    std::set<std::uint64_t> running;
    std::uint64_t forgotten = 0;  ///< the largest id whose answer is gone
    std::size_t bytes = 0;
    std::chrono::steady_clock::time_point touched;
    typename std::list<ClientId>::iterator age;
  };

  Client& touch(const ClientId& id) {
    const auto found = clients_.find(id);
    if (found != clients_.end()) {
      ages_.splice(ages_.end(), ages_, found->second.age);
      found->second.touched = std::chrono::steady_clock::now();
      return found->second;
    }
    if (clients_.size() >= limits_.clients) forgetOldestIdle();
    Client& client = clients_[id];
    client.age = ages_.insert(ages_.end(), id);
    client.touched = std::chrono::steady_clock::now();
    return client;
  }

  void forgetOldestIdle() {
    const auto idle = std::find_if(ages_.begin(), ages_.end(), [this](const ClientId& id) {
      return clients_.at(id).running.empty();
    });
    if (idle == ages_.end()) return;
    bytes_ -= clients_.at(*idle).bytes;
    clients_.erase(*idle);
    ages_.erase(idle);
  }

  void forget(Client& client, typename std::map<std::uint64_t, Kept>::iterator at) {
    client.forgotten = std::max(client.forgotten, at->first);
    client.bytes -= at->second.bytes;
    bytes_ -= at->second.bytes;
    client.answers.erase(at);
  }

  /// Forgets a client's oldest answers, but not `newest`.
  void trim(Client& client, std::uint64_t newest) {
    while (client.answers.size() > 1 && (client.answers.size() > limits_.answers_per_client ||
                                         client.bytes > limits_.bytes_per_client)) {
      auto oldest = client.answers.begin();
      if (oldest->first == newest) ++oldest;
      forget(client, oldest);
    }
  }

  /// Forgets answers of the clients that have been silent longest, but not of `newest`.
  void trimAll(const ClientId& newest) {
    for (const ClientId& id : ages_) {
      if (bytes_ <= limits_.bytes) return;
      if (id == newest) continue;
      Client& client = clients_.at(id);
      while (!client.answers.empty() && bytes_ > limits_.bytes) {
        forget(client, client.answers.begin());
      }
    }
  }

  DeduplicationLimits limits_;
  mutable std::mutex mutex_;
  std::map<ClientId, Client> clients_;
  std::list<ClientId> ages_;  ///< silent longest first
  std::size_t bytes_ = 0;
};

}  // namespace handgraft::server
