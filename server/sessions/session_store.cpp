#include "server/sessions/session_store.h"

#include <utility>

#include "core/base/random_id.h"
#include "server/base/rejection.h"

namespace handgraft::server {

std::uint64_t SessionStore::reserve() {
  requireRoom();
  const std::lock_guard lock(mutex_);
  std::uint64_t id = randomId();
  while (sessions_.count(id) + asleep_.count(id) != 0)
    id = randomId();
  return id;
}

void SessionStore::requireRoom() const {
  const std::lock_guard lock(mutex_);
  if (sessions_.size() < most_) return;
  reject(v1::ERROR_OVERLOADED,
         "{} sessions are open, as many as this server allows; close some", sessions_.size());
}

void SessionStore::sleep(v1::SessionState state) {
  const std::lock_guard lock(mutex_);
  sessions_.erase(state.session_id());
  const std::uint64_t id = state.session_id();
  asleep_[id] = std::move(state);
}

std::optional<v1::SessionState> SessionStore::asleep(std::uint64_t id) const {
  const std::lock_guard lock(mutex_);
  const auto found = asleep_.find(id);
  if (found == asleep_.end()) return std::nullopt;
  return found->second;
}

std::vector<v1::SessionState> SessionStore::states() const {
  std::vector<v1::SessionState> list;
  for (const auto& live : all())
    list.push_back(live->state());
  const std::lock_guard lock(mutex_);
  for (const auto& [id, state] : asleep_)
    list.push_back(state);
  return list;
}

void SessionStore::add(std::shared_ptr<LiveSession> session) {
  const std::lock_guard lock(mutex_);
  asleep_.erase(session->id());
  sessions_[session->id()] = std::move(session);
}

std::shared_ptr<LiveSession> SessionStore::find(std::uint64_t id) const {
  const std::lock_guard lock(mutex_);
  const auto found = sessions_.find(id);
  if (found == sessions_.end()) reject(v1::ERROR_NOT_FOUND, "session {} is not open", id);
  return found->second;
}

void SessionStore::remove(std::uint64_t id) {
  const std::lock_guard lock(mutex_);
  sessions_.erase(id);
  asleep_.erase(id);
}

std::vector<std::shared_ptr<LiveSession>> SessionStore::all() const {
  const std::lock_guard lock(mutex_);
  std::vector<std::shared_ptr<LiveSession>> list;
  for (const auto& [id, session] : sessions_)
    list.push_back(session);
  return list;
}

std::size_t SessionStore::size() const {
  const std::lock_guard lock(mutex_);
  return sessions_.size();
}

std::size_t SessionStore::countAll() const {
  const std::lock_guard lock(mutex_);
  return sessions_.size() + asleep_.size();
}

}  // namespace handgraft::server
