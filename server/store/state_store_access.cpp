// Whose the sessions of a store are.
#include <sstream>

#include "server/store/state_store.h"

namespace handgraft::server {

// Names have no blanks.

void StateStore::keepAccessLocked(std::uint64_t id, const SessionAccess& access) {
  std::string names;
  for (const std::string& name : access.identities)
    names += (names.empty() ? "" : " ") + name;
  Statement(*database_,
            "INSERT OR REPLACE INTO session_access(session, owner, access, identities) "
            "VALUES(?, ?, ?, ?)")
      .with(id, access.owner, static_cast<std::int64_t>(access.access), names)
      .run();
}

void StateStore::keepAccess(std::uint64_t id,
                            const SessionAccess& access,
                            const std::string& state) {
  const std::lock_guard lock(mutex_);
  Database::Transaction transaction(*database_);
  keepAccessLocked(id, access);
  Statement(*database_, "UPDATE sessions SET state = ? WHERE id = ?").with(state, id).run();
  transaction.commit();
  is_written_ = true;
}

SessionAccess StateStore::accessLocked(std::uint64_t id) const {
  SessionAccess access;
  Statement row(*database_,
                "SELECT owner, access, identities FROM session_access WHERE session = ?");
  row.with(id);
  while (row.step()) {
    access.owner = row.text(0);
    access.access = static_cast<v1::Access>(row.integer(1));
    std::istringstream names(row.text(2));
    for (std::string name; names >> name;)
      access.identities.push_back(name);
  }
  return access;
}

}  // namespace handgraft::server
