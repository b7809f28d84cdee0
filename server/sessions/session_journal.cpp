#include "server/sessions/session_journal.h"

#include "core/base/error.h"
#include "server/log/log.h"

namespace handgraft::server {

void SessionJournal::wrote() {
  next_ += waiting_.size();
  since_ += waiting_.size();
  waiting_.clear();
}

void SessionJournal::keepEdit(const std::string& entry,
                              const RequestKey& request_key,
                              const KeptEdit& outcome,
                              const std::vector<std::int64_t>& models) {
  waiting_.push_back(entry);
  try {
    store_.append(session_, next_, waiting_, &request_key, outcome, models);
  } catch (...) {
    waiting_.pop_back();
    throw;
  }
  wrote();
}

void SessionJournal::keep(const std::string& entry) {
  waiting_.push_back(entry);
  try {
    store_.append(session_, next_, waiting_);
    wrote();
  } catch (const std::exception& error) {
    log::warn("event=store_waits session={} entries={} what={}", session_, waiting_.size(),
              handgraft::quoted(error.what()));
  }
}

void SessionJournal::keepState(const std::string& state, std::uint64_t revision) {
  try {
    store_.append(session_, next_, waiting_, state, revision);
    wrote();
  } catch (const std::exception& error) {
    log::warn("event=store_waits session={} entries={} what={}", session_, waiting_.size(),
              handgraft::quoted(error.what()));
  }
}

void SessionJournal::keepText(const std::string& text,
                              const std::string& state,
                              std::uint64_t revision) {
  store_.replaceText(session_, text, next_ + waiting_.size(), state, revision);
  next_ += waiting_.size();
  waiting_.clear();
  since_ = 0;
}

}  // namespace handgraft::server
