#include "server/store/state_schema.h"

#include <cstdint>
#include <iterator>

#include <fmt/format.h>

#include "core/base/content_hash.h"
#include "core/base/error.h"

namespace handgraft::server {

namespace {

// Schema 1, then one step each. A file is brought from one to the next, never further at once.
constexpr const char* kSteps[] = {
    R"(
CREATE TABLE identity(name TEXT PRIMARY KEY, value INTEGER NOT NULL) WITHOUT ROWID;
CREATE TABLE blobs(hash TEXT PRIMARY KEY, size INTEGER NOT NULL, refs INTEGER NOT NULL) WITHOUT ROWID;
CREATE TABLE blob_parts(id INTEGER PRIMARY KEY, hash TEXT NOT NULL, part INTEGER NOT NULL,
  data BLOB NOT NULL, UNIQUE(hash, part));
CREATE TABLE models(id INTEGER PRIMARY KEY AUTOINCREMENT, kind INTEGER NOT NULL, name TEXT NOT NULL,
  listed INTEGER NOT NULL, content TEXT NOT NULL, summary TEXT NOT NULL, form TEXT NOT NULL,
  settings BLOB NOT NULL, blob TEXT NOT NULL, base INTEGER NOT NULL, base_name TEXT NOT NULL);
CREATE UNIQUE INDEX listed_models ON models(kind, name) WHERE listed = 1;
CREATE INDEX based_models ON models(base);
CREATE TABLE sessions(id INTEGER PRIMARY KEY, motion TEXT NOT NULL, next INTEGER NOT NULL,
  revision INTEGER NOT NULL, used INTEGER NOT NULL, state TEXT NOT NULL);
CREATE TABLE session_texts(session INTEGER PRIMARY KEY REFERENCES sessions(id) ON DELETE CASCADE,
  text BLOB NOT NULL);
CREATE TABLE session_models(session INTEGER NOT NULL REFERENCES sessions(id) ON DELETE CASCADE,
  model INTEGER NOT NULL REFERENCES models(id), PRIMARY KEY(session, model)) WITHOUT ROWID;
CREATE INDEX models_of_sessions ON session_models(model);
CREATE TABLE entries(session INTEGER NOT NULL REFERENCES sessions(id) ON DELETE CASCADE,
  number INTEGER NOT NULL, entry BLOB NOT NULL, PRIMARY KEY(session, number)) WITHOUT ROWID;
CREATE TABLE edits(asker BLOB NOT NULL, edit INTEGER NOT NULL,
  session INTEGER NOT NULL REFERENCES sessions(id) ON DELETE CASCADE, revision INTEGER NOT NULL,
  message TEXT NOT NULL, PRIMARY KEY(asker, edit)) WITHOUT ROWID;
CREATE INDEX edits_of_sessions ON edits(session, revision);
)",
    // 2: what requests made, so that their repeats make nothing again.
    R"(
CREATE TABLE requests(id INTEGER PRIMARY KEY AUTOINCREMENT, asker BLOB NOT NULL,
  request INTEGER NOT NULL, operation TEXT NOT NULL, subject INTEGER NOT NULL,
  UNIQUE(asker, request));
)",
    // 3: whose sessions are; those of before are nobody's, and everybody's.
    R"(
CREATE TABLE session_access(session INTEGER PRIMARY KEY REFERENCES sessions(id) ON DELETE CASCADE,
  owner TEXT NOT NULL, access INTEGER NOT NULL, identities TEXT NOT NULL);
)"};
static_assert(std::size(kSteps) == kStateSchema);

}  // namespace

void requireSchema(Database& database) {
  const auto schema = database.ask("PRAGMA user_version").value_or(0);
  if (schema > kStateSchema) {
    rejectInput(
        "store {}: its format is {}, of a newer handgraft-server; this one reads up to {}",
        database.path(), schema, kStateSchema);
  }
}

void bringToSchema(Database& database) {
  requireSchema(database);
  for (auto schema = database.ask("PRAGMA user_version").value_or(0); schema < kStateSchema;
       ++schema) {
    Database::Transaction transaction(database);
    database.execute(kSteps[schema]);
    database.execute(fmt::format("PRAGMA user_version = {}", schema + 1).c_str());
    transaction.commit();
  }
}

std::vector<std::string> problemsOf(Database& database) {
  std::vector<std::string> problems;
  const auto collect = [&](const std::string& sql, const std::string& what) {
    Statement rows(database, sql);
    while (rows.step())
      problems.push_back(what + rows.text(0));
  };
  {
    Statement pages(database, "PRAGMA integrity_check(100)");
    while (pages.step()) {
      if (const std::string line = pages.text(0); line != "ok")
        problems.push_back("file: " + line);
    }
  }
  if (!problems.empty()) return problems;
  Statement blobs(database, "SELECT hash, size, refs FROM blobs");
  Statement parts(database, "SELECT data FROM blob_parts WHERE hash = ? ORDER BY part");
  while (blobs.step()) {
    const std::string name = blobs.text(0);
    ContentHash hash;
    std::int64_t size = 0;
    parts.with(std::string_view(name));
    while (parts.step()) {
      const std::string data = parts.text(0);
      hash.add(data);
      size += static_cast<std::int64_t>(data.size());
    }
    if (blobs.integer(2) == 0) continue;  // being written, or left by a server that was killed
    if (size != blobs.integer(1) || hash.finish() != name)
      problems.push_back(fmt::format("blob {}: {} bytes are not what they were", name, size));
  }
  collect("SELECT name FROM models WHERE blob <> '' AND blob NOT IN (SELECT hash FROM blobs)",
          "model without its bytes: ");
  collect(
      "SELECT m.name FROM models m WHERE m.base <> 0 AND m.base NOT IN (SELECT id FROM models)",
      "model without what it rests on: ");
  collect(
      "SELECT hash FROM blobs b WHERE refs <> (SELECT count(*) FROM models WHERE blob = "
      "b.hash)",
      "blob whose references are miscounted: ");
  collect("SELECT id FROM sessions WHERE id NOT IN (SELECT session FROM session_texts)",
          "session without its text: ");
  collect(
      "SELECT s.id FROM sessions s WHERE (SELECT count(*) FROM entries WHERE session = s.id) "
      "<> "
      "(SELECT coalesce(max(number) - min(number) + 1, 0) FROM entries WHERE session = s.id)",
      "session with a gap in its history: ");
  collect(
      "SELECT s.id FROM sessions s WHERE coalesce((SELECT max(number) + 1 FROM entries WHERE "
      "session = s.id), s.next) < s.next",
      "session whose history ends before its text: ");
  collect("SELECT \"table\" || ' row ' || rowid FROM pragma_foreign_key_check",
          "reference to nothing: ");
  return problems;
}

}  // namespace handgraft::server
