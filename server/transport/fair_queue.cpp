#include "server/transport/fair_queue.h"

#include <algorithm>
#include <utility>

namespace handgraft::server {

namespace {

/// What a datagram takes beside its bytes: many empty ones are not for nothing.
constexpr std::size_t kOverhead = 64;

}  // namespace

bool FairQueue::push(const Sender& sender, std::span<const std::uint8_t> bytes) {
  const std::size_t taken = bytes.size() + kOverhead;
  bool was_empty = false;
  {
    const std::lock_guard lock(mutex_);
    if (is_shut_) return false;
    const auto [at, is_new] = waiting_.try_emplace(sender);
    Waiting& mine = at->second;
    if (!is_new && taken + mine.bytes > most_bytes_of_one_) return false;
    was_empty = turns_.empty();
    if (is_new) turns_.push_back(sender);
    mine.datagrams.emplace_back(bytes.begin(), bytes.end());
    mine.bytes += taken;
    bytes_ += taken;
    while (bytes_ > most_bytes_) {
      take(std::max_element(waiting_.begin(), waiting_.end(),
                            [](const auto& a, const auto& b) {
                              return a.second.bytes < b.second.bytes;
                            }),
           true);
    }
  }
  if (was_empty) changed_.notify_one();
  return true;
}

std::optional<FairQueue::Datagram> FairQueue::pop() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] {
    return is_shut_ || !turns_.empty();
  });
  if (is_shut_) return std::nullopt;
  // Behind all others, if more of it waits.
  turns_.splice(turns_.end(), turns_, turns_.begin());
  const Sender sender = turns_.back();
  return Datagram{sender, take(waiting_.find(sender), false)};
}

std::vector<std::uint8_t> FairQueue::take(AllWaiting::iterator whose, bool newest) {
  Waiting& waiting = whose->second;
  auto& datagrams = waiting.datagrams;
  std::vector<std::uint8_t> bytes = std::move(newest ? datagrams.back() : datagrams.front());
  if (newest)
    datagrams.pop_back();
  else
    datagrams.pop_front();
  waiting.bytes -= bytes.size() + kOverhead;
  bytes_ -= bytes.size() + kOverhead;
  if (datagrams.empty()) {
    turns_.remove(whose->first);
    waiting_.erase(whose);
  }
  return bytes;
}

std::size_t FairQueue::bytes() const {
  const std::lock_guard lock(mutex_);
  return bytes_;
}

void FairQueue::shut() {
  {
    const std::lock_guard lock(mutex_);
    is_shut_ = true;
  }
  changed_.notify_all();
}

}  // namespace handgraft::server
