#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "idl/models.h"
#include "server/store/state_store.h"

namespace handgraft::server {

/// What a session writes down as it goes, so that it is there again after its server died.
/// Of the session's strand. Errors of all that write: StorageError, Rejection (ERROR_STORAGE).
class SessionJournal {
 public:
  /// `next` is the number of the next entry, `since` how many there are since the text.
  SessionJournal(StateStore& store,
                 std::uint64_t session,
                 std::uint64_t next,
                 std::size_t since)
      : store_(store), session_(session), next_(next), since_(since) {}

  /// An edit that is about to stand: it is on disk when this returns, or was not done.
  void keepEdit(const std::string& entry,
                const RequestKey& request_key,
                const KeptEdit& outcome,
                const std::vector<std::int64_t>& models);

  /// Anything else, once it was done: on disk when this returns, or with what comes next.
  void keep(const std::string& entry);

  /// Likewise, with what comes next.
  void note(const std::string& entry) { waiting_.push_back(entry); }

  /// The state that all of it led to. Not written: as before.
  void keepState(const std::string& state, std::uint64_t revision);

  /// A text of the session as it stands, in place of what led to it.
  void keepText(const std::string& text, const std::string& state, std::uint64_t revision);

  /// How much has to be done again to open it.
  [[nodiscard]] std::size_t entriesSinceText() const { return since_ + waiting_.size(); }

  [[nodiscard]] bool knows(v1::ModelKind kind, const std::string& name) const {
    return named_.count({kind, name}) != 0;
  }

  /// True the first time: the session names that model from now on.
  bool names(v1::ModelKind kind, const std::string& name) {
    return named_.insert({kind, name}).second;
  }

  [[nodiscard]] StateStore& store() const { return store_; }

 private:
  void wrote();

  StateStore& store_;
  const std::uint64_t session_;
  std::uint64_t next_;
  std::size_t since_;
  std::vector<std::string> waiting_;  ///< done, and not written yet
  std::set<std::pair<v1::ModelKind, std::string>> named_;
};

}  // namespace handgraft::server
