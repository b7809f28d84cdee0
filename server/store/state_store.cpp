#include "server/store/state_store.h"

#include <cerrno>
#include <chrono>
#include <filesystem>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include "core/base/error.h"
#include "core/base/random_id.h"
#include "server/base/rejection.h"
#include "server/store/state_schema.h"

namespace handgraft::server {

namespace {

constexpr std::uint64_t kForEdits = 64ull << 20;  // beyond the quota
constexpr int kKeptEdits = 256;                   // marks, a session
constexpr int kKeptRequests = 10'000;             // marks, of all
constexpr std::chrono::seconds kFlush(1);
constexpr std::uint64_t kLongLog = 16ull << 20;  // bytes; then it is worked into the file

std::int64_t systemNs() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

}  // namespace

/// The statements of edits, prepared once.
struct StateStore::Statements {
  explicit Statements(Database& database)
      : entry(database, "INSERT INTO entries(session, number, entry) VALUES(?, ?, ?)"),
        edit(
            database,
            "INSERT INTO edits(asker, edit, session, revision, message) VALUES(?, ?, ?, ?, ?)"),
        state(database, "UPDATE sessions SET state = ?, revision = ?, used = ? WHERE id = ?"),
        revision(database, "UPDATE sessions SET revision = ? WHERE id = ?"),
        find_edit(database,
                  "SELECT session, revision, message FROM edits WHERE asker = ? AND edit = ?"),
        find_request(
            database,
            "SELECT operation, subject FROM requests WHERE asker = ? AND request = ?") {}

  Statement entry;
  Statement edit;
  Statement state;
  Statement revision;
  Statement find_edit;
  Statement find_request;
};

StateStore::StateStore(const std::string& path, StateLimits limits)
    : path_(path), limits_(limits) {
  if (path != ":memory:") {
    lock_ = ::open((path + ".lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    if (lock_ < 0) {
      throw StorageError(
          fmt::format("store {}: cannot be opened ({}); choose another folder by --state", path,
                      std::generic_category().message(errno)));
    }
    if (flock(lock_, LOCK_EX | LOCK_NB) != 0) {
      close(lock_);
      rejectInput(
          "store {}: another handgraft-server has it open; stop that one, or choose another "
          "folder by --state",
          path);
    }
  }
  try {
    open();
    if (path != ":memory:") {
      keeper_ = std::thread([this] {
        keep();
      });
    }
  } catch (...) {
    if (lock_ >= 0) close(lock_);
    throw;
  }
}

StateStore::~StateStore() {
  {
    const std::lock_guard lock(mutex_);
    stops_ = true;
  }
  wake_.notify_all();
  if (keeper_.joinable()) keeper_.join();
  statements_.reset();
  database_.reset();
  if (lock_ >= 0) close(lock_);
}

void StateStore::open() {
  database_ = std::make_unique<Database>(path_);
  bringToSchema(*database_);
  if (const auto id = database_->ask("SELECT value FROM identity WHERE name = 'server'")) {
    server_id_ = static_cast<std::uint64_t>(*id);
  } else {
    server_id_ = randomId();
  }
  openings_ =
      static_cast<std::uint64_t>(
          database_->ask("SELECT value FROM identity WHERE name = 'openings'").value_or(0)) +
      1;
  Database::Transaction transaction(*database_);
  Statement set(*database_, "INSERT OR REPLACE INTO identity(name, value) VALUES(?, ?)");
  set.with(std::string_view("server"), server_id_).run();
  set.with(std::string_view("openings"), openings_).run();
  // What a server that was killed had begun to write.
  database_->execute(
      "DELETE FROM blob_parts WHERE hash IN (SELECT hash FROM blobs WHERE refs = 0)");
  database_->execute("DELETE FROM blobs WHERE refs = 0");
  transaction.commit();
  statements_ = std::make_unique<Statements>(*database_);
  Statement askers(*database_, "SELECT DISTINCT asker FROM edits");
  while (askers.step())
    earlier_askers_.insert(askers.text(0));
}

std::uint64_t StateStore::bytes() const {
  const std::lock_guard lock(mutex_);
  return database_->bytes();
}

void StateStore::requireRoom(std::uint64_t more, std::uint64_t most) const {
  const std::uint64_t held = database_->bytes();
  if (held + more <= most) return;
  reject(v1::ERROR_STORAGE,
         "the server's store holds {} MB of at most {} MB: no room for {} kB more; close "
         "sessions, or unload models",
         held >> 20, limits_.bytes >> 20, (more >> 10) + 1);
}

void StateStore::noteRequest(const RequestKey& by,
                             const std::string& operation,
                             std::int64_t subject) {
  if (by.asker.empty()) return;
  Statement(*database_,
            "INSERT OR REPLACE INTO requests(asker, request, operation, subject) "
            "VALUES(?, ?, ?, ?)")
      .with(Bytes{by.asker}, by.number, operation, subject)
      .run();
  Statement(*database_, "DELETE FROM requests WHERE id <= last_insert_rowid() - ?")
      .with(kKeptRequests)
      .run();
}

// === Sessions

void StateStore::addSession(std::uint64_t id,
                            const KeptSession& session,
                            const std::string& state,
                            const RequestKey& by,
                            const std::string& operation) {
  const std::lock_guard lock(mutex_);
  requireRoom(session.text.size(), limits_.bytes);
  const auto there = database_->ask("SELECT count(*) FROM sessions").value_or(0);
  if (static_cast<std::size_t>(there) >= limits_.sessions) {
    reject(v1::ERROR_STORAGE,
           "the server's store holds {} sessions, as many as it may; close some", there);
  }
  Database::Transaction transaction(*database_);
  Statement(*database_,
            "INSERT INTO sessions(id, motion, next, revision, used, state) "
            "VALUES(?, ?, 0, 0, ?, ?)")
      .with(id, session.motion, systemNs(), state)
      .run();
  Statement(*database_, "INSERT INTO session_texts(session, text) VALUES(?, ?)")
      .with(id, session.text)
      .run();
  Statement models(*database_,
                   "INSERT OR IGNORE INTO session_models(session, model) VALUES(?, ?)");
  for (const std::int64_t model : session.models)
    models.with(id, model).run();
  keepAccessLocked(id, session.access);
  noteRequest(by, operation, static_cast<std::int64_t>(id));
  transaction.commit();
  is_written_ = true;
}

void StateStore::appendLocked(std::uint64_t id,
                              std::uint64_t first,
                              const std::vector<std::string>& entries,
                              const RequestKey* edit,
                              const KeptEdit& outcome) {
  for (const std::string& entry : entries)
    statements_->entry.with(id, first++, entry).run();
  if (edit == nullptr) return;
  statements_->edit
      .with(Bytes{edit->asker}, edit->number, id, outcome.revision, outcome.message)
      .run();
  statements_->revision.with(outcome.revision, id).run();
}

void StateStore::append(std::uint64_t id,
                        std::uint64_t first,
                        const std::vector<std::string>& entries,
                        const RequestKey* edit,
                        const KeptEdit& outcome,
                        const std::vector<std::int64_t>& models) {
  const std::lock_guard lock(mutex_);
  requireRoom(0, limits_.bytes + kForEdits);
  Database::Transaction transaction(*database_);
  appendLocked(id, first, entries, edit, outcome);
  for (const std::int64_t model : models) {
    Statement(*database_, "INSERT OR IGNORE INTO session_models(session, model) VALUES(?, ?)")
        .with(id, model)
        .run();
  }
  transaction.commit();
  is_written_ = true;
}

void StateStore::append(std::uint64_t id,
                        std::uint64_t first,
                        const std::vector<std::string>& entries,
                        const std::string& state,
                        std::uint64_t revision) {
  const std::lock_guard lock(mutex_);
  Database::Transaction transaction(*database_);
  appendLocked(id, first, entries, nullptr, {});
  statements_->state.with(state, revision, systemNs(), id).run();
  transaction.commit();
  is_written_ = true;
}

void StateStore::replaceText(std::uint64_t id,
                             const std::string& text,
                             std::uint64_t next,
                             const std::string& state,
                             std::uint64_t revision) {
  const std::lock_guard lock(mutex_);
  Database::Transaction transaction(*database_);
  Statement(*database_, "UPDATE session_texts SET text = ? WHERE session = ?")
      .with(text, id)
      .run();
  Statement(*database_, "UPDATE sessions SET next = ? WHERE id = ?").with(next, id).run();
  Statement(*database_, "DELETE FROM entries WHERE session = ? AND number < ?")
      .with(id, next)
      .run();
  Statement(*database_, "DELETE FROM edits WHERE session = ? AND revision <= ? - ?")
      .with(id, revision, kKeptEdits)
      .run();
  // Written anew is not used: it may be put to sleep, or the server may end.
  Statement(*database_, "UPDATE sessions SET state = ?, revision = ? WHERE id = ?")
      .with(state, revision, id)
      .run();
  transaction.commit();
  is_written_ = true;
}

void StateStore::removeSession(std::uint64_t id,
                               const RequestKey& by,
                               const std::string& operation) {
  const std::lock_guard lock(mutex_);
  Database::Transaction transaction(*database_);
  Statement(*database_, "DELETE FROM sessions WHERE id = ?").with(id).run();
  dropModels();
  noteRequest(by, operation, static_cast<std::int64_t>(id));
  transaction.commit();
  is_written_ = true;
}

std::vector<KeptSessionState> StateStore::sessions() const {
  const std::lock_guard lock(mutex_);
  std::vector<KeptSessionState> list;
  Statement rows(*database_,
                 "SELECT id, state, revision, used FROM sessions ORDER BY used DESC, id");
  while (rows.step())
    list.push_back({rows.id(0), rows.text(1), rows.id(2), rows.integer(3)});
  return list;
}

KeptSession StateStore::session(std::uint64_t id) const {
  const std::lock_guard lock(mutex_);
  KeptSession session;
  bool is_there = false;
  Statement row(
      *database_,
      "SELECT t.text, s.motion, s.next, s.used FROM sessions s JOIN session_texts t ON "
      "t.session = s.id WHERE s.id = ?");
  row.with(id);
  while (row.step()) {
    is_there = true;
    session.text = row.text(0);
    session.motion = row.text(1);
    session.next = row.id(2);
    session.used = row.integer(3);
  }
  if (!is_there) throw StorageError(fmt::format("store {}: it has no session {}", path_, id));
  Statement entries(*database_,
                    "SELECT entry, number FROM entries WHERE session = ? ORDER BY number");
  entries.with(id);
  while (entries.step()) {
    if (entries.id(1) != session.next + session.entries.size()) {
      throw StorageError(
          fmt::format("store {}: session {} lacks a part of its history", path_, id));
    }
    session.entries.push_back(entries.text(0));
  }
  Statement models(*database_, "SELECT model FROM session_models WHERE session = ?");
  models.with(id);
  while (models.step())
    session.models.push_back(models.integer(0));
  session.access = accessLocked(id);
  return session;
}

// === What was done for whom

std::optional<KeptEdit> StateStore::edit(const RequestKey& edit) const {
  if (earlier_askers_.count(edit.asker) == 0) return std::nullopt;
  const std::lock_guard lock(mutex_);
  std::optional<KeptEdit> found;
  statements_->find_edit.with(Bytes{edit.asker}, edit.number);
  while (statements_->find_edit.step()) {
    found = KeptEdit{statements_->find_edit.id(0), statements_->find_edit.id(1),
                     statements_->find_edit.text(2)};
  }
  return found;
}

std::optional<KeptRequest> StateStore::request(const RequestKey& request) const {
  const std::lock_guard lock(mutex_);
  std::optional<KeptRequest> found;
  statements_->find_request.with(Bytes{request.asker}, request.number);
  while (statements_->find_request.step()) {
    found =
        KeptRequest{statements_->find_request.text(0), statements_->find_request.integer(1)};
  }
  return found;
}

// === Upkeep

std::vector<std::string> StateStore::check() const {
  const std::lock_guard lock(mutex_);
  return problemsOf(*database_);
}

void StateStore::backUpTo(const std::string& path) const {
  if (path_ != ":memory:") return backUpStore(path_, path);
  if (std::filesystem::exists(path)) rejectInput("{}: exists already", path);
  const std::lock_guard lock(mutex_);
  database_->backUpTo(path);
}

/// Sees to it, once a second, that what was committed lies on the disk, and that the log does
/// not grow for ever: on a thread and a connection of its own, so that no edit waits for it.
void StateStore::keep() {
  std::unique_lock lock(mutex_);
  bool was_written = false;
  std::unique_ptr<Database> mine;
  const std::string log = path_ + "-wal";
  while (true) {
    wake_.wait_for(lock, kFlush, [this] {
      return stops_;
    });
    const bool stops = stops_;
    const bool is_written = std::exchange(is_written_, false);
    lock.unlock();
    if (is_written) {
      const int file = ::open(log.c_str(), O_RDWR | O_CLOEXEC);
      if (file >= 0) {
        static_cast<void>(fdatasync(file));  // the next second tries again
        close(file);
      }
    }
    std::error_code error;
    const auto length = std::filesystem::file_size(log, error);
    // In a pause, or where it is long: writers go on meanwhile.
    const bool is_quiet = was_written && !is_written;
    if (!error && !stops && (length > kLongLog || is_quiet)) {
      try {
        if (!mine) mine = std::make_unique<Database>(path_);
        mine->ask("PRAGMA wal_checkpoint(PASSIVE)");
      } catch (const StorageError&) {  // who writes will be told
        mine.reset();
      }
    }
    was_written = is_written;
    lock.lock();
    if (stops) return;
  }
}

std::vector<std::string> checkStore(const std::string& path) {
  if (!std::filesystem::exists(path)) rejectInput("store {}: there is none", path);
  try {
    Database database(path);
    requireSchema(database);
    return problemsOf(database);
  } catch (const StorageError& error) {  // so damaged that it cannot be asked
    return {error.what()};
  }
}

void backUpStore(const std::string& path, const std::string& to) {
  if (!std::filesystem::exists(path)) rejectInput("store {}: there is none", path);
  if (std::filesystem::exists(to)) rejectInput("{}: exists already", to);
  Database database(path);
  requireSchema(database);
  database.backUpTo(to);
}

}  // namespace handgraft::server
