#include "server/store/database.h"

#include <cerrno>
#include <utility>

#include <fmt/format.h>
#include <sqlite3.h>

namespace handgraft::server {

namespace {

/// What an error means for who keeps the store, and what to do; null where SQLite's own words
/// have to do. `code` is SQLite's, extended or not, `os` the system's.
const char* adviceOn(int code, int os) {
  constexpr int kPrimary = 0xff;
  const bool has_no_room = os == ENOSPC || os == EDQUOT;
  const bool may_not = os == EACCES || os == EPERM || os == EROFS;
  switch (code & kPrimary) {
    case SQLITE_IOERR:
    case SQLITE_CANTOPEN:
      if (!has_no_room && !may_not) return nullptr;
      break;
    case SQLITE_FULL:
    case SQLITE_READONLY:
      break;
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
      return "it is damaged, or no store; move it away and put a copy (--backup) in its place, "
             "or start without one; --check lists what is wrong";
    default:
      return nullptr;
  }
  const bool is_full = (code & kPrimary) == SQLITE_FULL || has_no_room;
  return is_full ? "the disk is full; make room on it, or choose another folder by --state"
                 : "it is read-only; let the server's user write to the file and its folder, "
                   "or choose another folder by --state";
}

std::string complaint(const std::string& path, const std::string& what, sqlite3* handle) {
  const int code = sqlite3_extended_errcode(handle);
  const int os = sqlite3_system_errno(handle);
  const char* advice = adviceOn(code, os);
  return advice != nullptr ? fmt::format("store {}: {} ({}: SQLite {}, system {})", path,
                                         advice, what, code, os)
                           : fmt::format("store {}: {} failed: {} (SQLite {}, system {})", path,
                                         what, sqlite3_errmsg(handle), code, os);
}

}  // namespace

// === Statement

Statement::Statement(Database& database, const std::string& sql) : database_(database) {
  const int result = sqlite3_prepare_v3(database.handle_, sql.c_str(), -1,
                                        SQLITE_PREPARE_PERSISTENT, &statement_, nullptr);
  if (result != SQLITE_OK) database.fail("prepare");
}

Statement::~Statement() {
  sqlite3_finalize(statement_);
}

Statement::Statement(Statement&& other) noexcept
    : database_(other.database_), statement_(std::exchange(other.statement_, nullptr)) {}

bool Statement::step() {
  switch (sqlite3_step(statement_)) {
    case SQLITE_ROW:
      return true;
    case SQLITE_DONE:
      sqlite3_reset(statement_);
      return false;
    default:
      break;
  }
  try {
    database_.fail("write");
  } catch (...) {
    sqlite3_reset(statement_);  // after the words: it may change them
    throw;
  }
}

void Statement::run() {
  while (step()) {
  }
}

void Statement::reset() {
  sqlite3_reset(statement_);
  sqlite3_clear_bindings(statement_);
}

void Statement::bind(int index, std::int64_t value) {
  if (sqlite3_bind_int64(statement_, index, value) != SQLITE_OK) database_.fail("bind");
}

void Statement::bind(int index, Bytes bytes) {
  const char* data = bytes.data.data() == nullptr ? "" : bytes.data.data();
  if (sqlite3_bind_blob64(statement_, index, data, bytes.data.size(), SQLITE_STATIC) !=
      SQLITE_OK)
    database_.fail("bind");
}

void Statement::bind(int index, std::string_view text) {
  const char* data = text.data() == nullptr ? "" : text.data();
  if (sqlite3_bind_text64(statement_, index, data, text.size(), SQLITE_STATIC, SQLITE_UTF8) !=
      SQLITE_OK)
    database_.fail("bind");
}

std::int64_t Statement::integer(int column) const {
  return sqlite3_column_int64(statement_, column);
}

std::uint64_t Statement::id(int column) const {
  return static_cast<std::uint64_t>(integer(column));
}

std::string Statement::text(int column) const {
  const void* bytes = sqlite3_column_blob(statement_, column);
  const int size = sqlite3_column_bytes(statement_, column);
  if (bytes == nullptr || size <= 0) return {};
  return {static_cast<const char*>(bytes), static_cast<std::size_t>(size)};
}

bool Statement::isNull(int column) const {
  return sqlite3_column_type(statement_, column) == SQLITE_NULL;
}

// === Database

Database::Database(const std::string& path) : path_(path) {
  constexpr int kHowOpened =
      SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX | SQLITE_OPEN_EXRESCODE;
  constexpr int kPatienceMs = 5000;  // of two connections for each other
  if (sqlite3_open_v2(path.c_str(), &handle_, kHowOpened, nullptr) != SQLITE_OK) {
    const std::string why = handle_ != nullptr ? complaint(path, "open", handle_)
                                               : fmt::format("store {}: no memory", path);
    sqlite3_close(handle_);
    throw StorageError(why);
  }
  try {
    sqlite3_busy_timeout(handle_, kPatienceMs);
    execute("PRAGMA journal_mode=WAL");
    execute("PRAGMA synchronous=NORMAL");
    execute("PRAGMA foreign_keys=ON");
    execute("PRAGMA wal_autocheckpoint=0");  // done beside, by who keeps the store
    execute("PRAGMA temp_store=MEMORY");
  } catch (...) {
    sqlite3_close_v2(handle_);
    throw;
  }
}

Database::~Database() {
  sqlite3_close_v2(handle_);
}

void Database::fail(const std::string& what) const {
  throw StorageError(complaint(path_, what, handle_));
}

void Database::execute(const char* sql) {
  if (sqlite3_exec(handle_, sql, nullptr, nullptr, nullptr) != SQLITE_OK) fail(sql);
}

std::optional<std::int64_t> Database::ask(const std::string& sql) {
  Statement statement(*this, sql);
  if (!statement.step() || statement.isNull(0)) return std::nullopt;
  return statement.integer(0);
}

Database::Transaction::Transaction(Database& database) : database_(database) {
  database_.execute("BEGIN IMMEDIATE");
}

Database::Transaction::~Transaction() {
  if (!is_open_) return;
  // Some errors have rolled back by themselves; then this has nothing to say.
  sqlite3_exec(database_.handle_, "ROLLBACK", nullptr, nullptr, nullptr);
}

void Database::Transaction::commit() {
  database_.execute("COMMIT");
  is_open_ = false;
}

void Database::backUpTo(const std::string& path) {
  Database to(path);
  sqlite3_backup* copy = sqlite3_backup_init(to.handle_, "main", handle_, "main");
  if (copy == nullptr) to.fail("backup");
  // In one step, from one state of the file: writers go on in its log meanwhile.
  int result = SQLITE_BUSY;
  while (result == SQLITE_BUSY || result == SQLITE_LOCKED) {
    result = sqlite3_backup_step(copy, -1);
    if (result == SQLITE_BUSY || result == SQLITE_LOCKED) sqlite3_sleep(10);
  }
  sqlite3_backup_finish(copy);
  if (result != SQLITE_DONE) to.fail("backup");
  // A backup is one file: no log beside it.
  to.execute("PRAGMA journal_mode=DELETE");
}

std::uint64_t Database::bytes() {
  const auto pages = ask("PRAGMA page_count").value_or(0);
  const auto free = ask("PRAGMA freelist_count").value_or(0);
  const auto size = ask("PRAGMA page_size").value_or(0);
  return static_cast<std::uint64_t>((pages - free) * size);
}

}  // namespace handgraft::server
