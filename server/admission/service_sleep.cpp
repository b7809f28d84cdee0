// How the service lists the sessions that a store keeps, opens them when they are asked for,
// and puts them to sleep.
#include <algorithm>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "idl/json.h"
#include "server/admission/service.h"
#include "server/base/rejection.h"
#include "server/handlers/kept_sessions.h"
#include "server/log/log.h"

namespace handgraft::server {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kMostWaking = 256;         // that wait for one session to open
constexpr std::chrono::seconds kIdleInNeed(10);  // of sessions where others find no room
// Those that were in use when the server before this one ended.
constexpr std::chrono::minutes kInUse(10);
constexpr std::size_t kMostInUse = 16;

}  // namespace

void Service::listKeptSessions() {
  const std::int64_t recently =
      nowNs() - std::chrono::duration_cast<std::chrono::nanoseconds>(kInUse).count();
  for (const KeptSessionState& kept : options_.state->sessions()) {
    v1::SessionState state;
    try {
      state = idl::fromJsonText<v1::SessionState>(kept.state);
    } catch (const std::exception& error) {  // a list with less in it
      log::warn("event=kept_state session={} what={}", kept.id,
                handgraft::quoted(error.what()));
    }
    state.session_id(kept.id);
    state.server_id(server_id_);
    state.revision(kept.revision);
    if (state.phase() != v1::PHASE_OPEN) state.phase(v1::PHASE_READY);
    state.message("");
    sessions_.sleep(std::move(state));
    if (kept.used > recently && last_used_.size() < kMostInUse) last_used_.push_back(kept.id);
  }
}

void Service::wakeTheLastUsed() {
  for (const std::uint64_t id : last_used_) {
    whenOpen(
        id, [](const auto&) {}, [](const auto&) {});
  }
  last_used_.clear();
}

void Service::whenOpen(std::uint64_t id, WithSession then, const WithoutSession& otherwise) {
  try {
    const std::lock_guard lock(waking_mutex_);
    if (!sessions_.asleep(id)) return then(sessions_.find(id));
    std::vector<Waiting>& waiting = waking_[id];
    if (waiting.size() >= kMostWaking) {
      reject(v1::ERROR_OVERLOADED, "too many requests wait for session {}; try later", id);
    }
    const bool is_first = waiting.empty();
    waiting.push_back({std::move(then), otherwise});
    if (!is_first) return;
    const bool is_taken = pool_.post([this, id] {
      wake(id);
    });
    if (is_taken) return;
    waking_.erase(id);
    reject(v1::ERROR_OVERLOADED, "too many requests wait; try later");
  } catch (...) {
    otherwise(std::current_exception());
  }
}

void Service::wake(std::uint64_t id) {
  std::shared_ptr<LiveSession> live;
  std::exception_ptr trouble;
  const Clock::time_point begin = Clock::now();
  try {
    sessions_.requireRoom();
    live = openKeptSession(id, context_, Progress());
    log::info("event=session_opened session={} revision={} ms={:.1f}", id,
              live->session().revision(),
              std::chrono::duration<double, std::milli>(Clock::now() - begin).count());
  } catch (const std::exception& error) {
    log::warn("event=session_stays_closed session={} what={}", id,
              handgraft::quoted(error.what()));
    trouble = std::current_exception();
  }
  const std::lock_guard lock(waking_mutex_);
  const std::vector<Waiting> waiting = std::move(waking_[id]);
  waking_.erase(id);
  if (live) {
    live->prepareSolids(live, pool_);
    sessions_.add(live);
    live->enter(v1::PHASE_OPEN);
    static_cast<void>(live->strand().post([this, live] {
      resumeKeptSession(*live, context_);
    }));
  }
  for (const Waiting& one : waiting) {
    if (trouble) {
      one.otherwise(trouble);
      continue;
    }
    try {
      one.then(live);
    } catch (...) {
      one.otherwise(std::current_exception());
    }
  }
}

void Service::putIdleSessionsToSleep() {
  // Room is made before there is none, by those that were idle longest; so many a second, since
  // each takes a place in the pool, where others' edits wait, too.
  constexpr std::size_t kMostAtOnce = 16;
  const std::size_t wanted = options_.most_sessions * 9 / 10;
  std::vector<std::pair<Clock::duration, std::shared_ptr<LiveSession>>> idle;
  for (const auto& live : sessions_.all())
    idle.emplace_back(live->idle(), live);
  std::sort(idle.begin(), idle.end(), [](const auto& a, const auto& b) {
    return a.first > b.first;
  });
  std::size_t excess = idle.size() - std::min(idle.size(), wanted);
  if (idle.size() > kMostAtOnce) idle.resize(kMostAtOnce);
  for (const auto& [time, live] : idle) {
    const bool is_in_the_way = excess > 0 && time >= kIdleInNeed;
    if (!is_in_the_way && time < options_.session_idle) return;
    putToSleepAfter(live, std::chrono::duration_cast<std::chrono::seconds>(time));
    if (excess > 0) --excess;
  }
}

void Service::putToSleepAfter(const std::shared_ptr<LiveSession>& live,
                              std::chrono::seconds idle) {
  const bool is_taken = live->strand().post([this, live, idle] {
    const auto is_wanted = [&] {
      return live->idle() < idle || live->is_asleep || live->isClosed();
    };
    if (is_wanted()) return;
    try {
      keepText(*live);  // takes its time, in which others' sessions are asked for
      const std::lock_guard lock(waking_mutex_);  // who asks now finds it, or finds it asleep
      if (is_wanted()) return;
      putToSleep(*live, context_);
      bus_.rest(live->id());
      log::info("event=session_sleeps session={}", live->id());
    } catch (const std::exception& error) {
      log::warn("event=store_waits session={} what={}", live->id(),
                handgraft::quoted(error.what()));
    }
  });
  if (!is_taken) log::debug("event=sleep_waits session={}", live->id());
}

}  // namespace handgraft::server
