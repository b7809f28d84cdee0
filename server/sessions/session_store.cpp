#include "server/sessions/session_store.h"

#include <utility>

#include "core/base/random_id.h"
#include "server/admission/rejection.h"

namespace handgraft::server {

std::uint64_t SessionStore::reserve() {
  const std::lock_guard lock(mutex_);
  if (sessions_.size() >= most_) {
    reject(v1::ERROR_OVERLOADED,
           "{} sessions are open, as many as this server allows; close some", sessions_.size());
  }
  std::uint64_t id = randomId();
  while (sessions_.count(id) != 0)
    id = randomId();
  return id;
}

void SessionStore::add(std::shared_ptr<LiveSession> session) {
  const std::lock_guard lock(mutex_);
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

}  // namespace handgraft::server
