#include "server/transport/fair_queue.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "server/transport/sender_state.h"

namespace handgraft::server {

namespace {

constexpr unsigned kTurnsAHeartbeat = 4;

/// What a datagram takes beside its bytes: many empty ones are not for nothing.
constexpr std::size_t kOverhead = 64;

}  // namespace

std::size_t FairQueue::costOf(const Kept& one) {
  return one.bytes.size() + 2 * one.state.size() + kOverhead;
}

bool FairQueue::push(const Sender& sender, std::span<const std::uint8_t> bytes) {
  SenderState state = senderStateOf(bytes);
  Kept newest{{bytes.begin(), bytes.end()}, std::move(state.key)};
  const std::size_t taken = costOf(newest);
  {
    const std::lock_guard lock(mutex_);
    if (is_shut_) return false;
    const auto at = waiting_.try_emplace(sender).first;
    Waiting& mine = at->second;
    Line& line = state.is_heartbeat ? mine.heartbeats : mine.others;
    auto& turns = state.is_heartbeat ? turns_of_heartbeats_ : turns_;
    const bool has_turn = !line.empty();
    if (const auto before = mine.states.find(newest.state); before != mine.states.end())
      take(mine, line, before->second);
    if (mine.bytes > 0 && taken + mine.bytes > most_bytes_of_one_) {
      tidy(at);
      return false;
    }
    if (!has_turn) turns.push_back(sender);
    line.push_back(std::move(newest));
    const auto last = std::prev(line.end());
    if (!last->state.empty()) mine.states[last->state] = last;
    mine.bytes += taken;
    bytes_ += taken;
    while (bytes_ > most_bytes_) {
      const auto most =
          std::max_element(waiting_.begin(), waiting_.end(), [](const auto& a, const auto& b) {
            return a.second.bytes < b.second.bytes;
          });
      Line& longest =
          most->second.others.empty() ? most->second.heartbeats : most->second.others;
      take(most->second, longest, std::prev(longest.end()));
      tidy(most);
    }
  }
  changed_.notify_one();
  return true;
}

std::optional<FairQueue::Datagram> FairQueue::pop() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] {
    return is_shut_ || !waiting_.empty();
  });
  if (is_shut_) return std::nullopt;
  const bool is_heartbeats_turn =
      turns_.empty() || (++taken_ % kTurnsAHeartbeat == 0 && !turns_of_heartbeats_.empty());
  auto& turns = is_heartbeats_turn ? turns_of_heartbeats_ : turns_;
  const auto whose = waiting_.find(turns.front());
  Line& line = is_heartbeats_turn ? whose->second.heartbeats : whose->second.others;
  Datagram next{whose->first, take(whose->second, line, line.begin())};
  // Behind all others, if more of it waits.
  if (line.empty())
    turns.pop_front();
  else
    turns.splice(turns.end(), turns, turns.begin());
  if (whose->second.bytes == 0) waiting_.erase(whose);
  return next;
}

std::vector<std::uint8_t> FairQueue::take(Waiting& waiting, Line& line, Line::iterator which) {
  const std::size_t cost = costOf(*which);
  std::vector<std::uint8_t> bytes = std::move(which->bytes);
  if (!which->state.empty()) waiting.states.erase(which->state);
  line.erase(which);
  waiting.bytes -= cost;
  bytes_ -= cost;
  return bytes;
}

void FairQueue::tidy(AllWaiting::iterator whose) {
  const Sender sender = whose->first;
  if (whose->second.others.empty()) turns_.remove(sender);
  if (whose->second.heartbeats.empty()) turns_of_heartbeats_.remove(sender);
  if (whose->second.others.empty() && whose->second.heartbeats.empty()) waiting_.erase(whose);
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
