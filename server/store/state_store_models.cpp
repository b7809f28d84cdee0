// Models in the store: their bytes, once each, and who rests on whom.
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "core/base/content_hash.h"
#include "server/store/state_store.h"

namespace handgraft::server {

namespace {

constexpr std::size_t kPart = 1u << 20;  // bytes of a blob in one transaction

std::string hashOf(std::string_view bytes) {
  ContentHash hash;
  hash.add(bytes);
  return hash.finish();
}

PersistedModel modelOf(const Statement& row) {
  PersistedModel model;
  model.row = row.integer(0);
  model.kind = static_cast<int>(row.integer(1));
  model.name = row.text(2);
  model.content = row.text(3);
  model.summary = row.text(4);
  model.form = row.text(5);
  model.settings = row.text(6);
  model.base = row.integer(7);
  model.base_name = row.text(8);
  return model;
}

constexpr const char* kModelColumns =
    "id, kind, name, content, summary, form, settings, base, base_name";

}  // namespace

std::string StateStore::addBlob(std::string_view bytes) {
  std::string hash = hashOf(bytes);
  {
    const std::lock_guard lock(mutex_);
    requireRoom(bytes.size(), limits_.bytes);
    Statement there(*database_, "SELECT refs FROM blobs WHERE hash = ?");
    there.with(hash);
    bool is_whole = false;
    while (there.step())
      is_whole = there.integer(0) > 0;
    if (is_whole) return hash;
    Statement(*database_, "INSERT OR IGNORE INTO blobs(hash, size, refs) VALUES(?, ?, 0)")
        .with(hash, static_cast<std::uint64_t>(bytes.size()))
        .run();
  }
  // Part by part: edits of others go between.
  for (std::size_t begin = 0, part = 0; begin < bytes.size(); begin += kPart, ++part) {
    const std::lock_guard lock(mutex_);
    Statement(*database_, "INSERT OR REPLACE INTO blob_parts(hash, part, data) VALUES(?, ?, ?)")
        .with(hash, static_cast<std::uint64_t>(part), Bytes{bytes.substr(begin, kPart)})
        .run();
  }
  return hash;
}

std::int64_t StateStore::addModel(const PersistedModel& model,
                                  std::string_view bytes,
                                  const RequestKey& by,
                                  const std::string& operation) {
  const std::lock_guard one_blob(blob_mutex_);
  const std::string blob = bytes.empty() ? std::string() : addBlob(bytes);
  const std::lock_guard lock(mutex_);
  Database::Transaction transaction(*database_);
  if (!blob.empty())
    Statement(*database_, "UPDATE blobs SET refs = refs + 1 WHERE hash = ?").with(blob).run();
  Statement(
      *database_,
      "INSERT INTO models(kind, name, listed, content, summary, form, settings, blob, base, "
      "base_name) VALUES(?, ?, 1, ?, ?, ?, ?, ?, ?, ?)")
      .with(model.kind, model.name, model.content, model.summary, model.form,
            Bytes{model.settings}, blob, model.base, model.base_name)
      .run();
  const std::int64_t row = database_->ask("SELECT last_insert_rowid()").value_or(0);
  noteRequest(by, operation, row);
  transaction.commit();
  is_written_ = true;
  return row;
}

void StateStore::removeModel(int kind,
                             const std::string& name,
                             const RequestKey& by,
                             const std::string& operation) {
  const std::lock_guard lock(mutex_);
  Database::Transaction transaction(*database_);
  Statement(*database_, "UPDATE models SET listed = 0 WHERE kind = ? AND name = ?")
      .with(kind, name)
      .run();
  dropModels();
  noteRequest(by, operation, 0);
  transaction.commit();
  is_written_ = true;
}

// Those without a name that nothing rests on, and what those alone rested on, and so on.
void StateStore::dropModels() {
  while (true) {
    std::vector<std::pair<std::int64_t, std::string>> free;
    {
      Statement rows(
          *database_,
          "SELECT id, blob FROM models m WHERE listed = 0 AND NOT EXISTS (SELECT 1 FROM "
          "session_models WHERE model = m.id) AND NOT EXISTS (SELECT 1 FROM models "
          "WHERE base = m.id)");
      while (rows.step())
        free.emplace_back(rows.integer(0), rows.text(1));
    }
    if (free.empty()) return;
    for (const auto& [row, blob] : free) {
      Statement(*database_, "DELETE FROM models WHERE id = ?").with(row).run();
      if (blob.empty()) continue;
      Statement(*database_, "UPDATE blobs SET refs = refs - 1 WHERE hash = ?").with(blob).run();
      Statement(*database_,
                "DELETE FROM blob_parts WHERE hash = ? AND EXISTS (SELECT 1 FROM blobs WHERE "
                "hash = blob_parts.hash AND refs = 0)")
          .with(blob)
          .run();
      Statement(*database_, "DELETE FROM blobs WHERE hash = ? AND refs = 0").with(blob).run();
    }
  }
}

std::vector<PersistedModel> StateStore::models() const {
  const std::lock_guard lock(mutex_);
  std::vector<PersistedModel> list;
  Statement rows(*database_,
                 fmt::format("SELECT {} FROM models WHERE listed = 1", kModelColumns));
  while (rows.step())
    list.push_back(modelOf(rows));
  return list;
}

PersistedModel StateStore::model(std::int64_t row) const {
  const std::lock_guard lock(mutex_);
  std::optional<PersistedModel> found;
  Statement rows(*database_, fmt::format("SELECT {} FROM models WHERE id = ?", kModelColumns));
  rows.with(row);
  while (rows.step())
    found = modelOf(rows);
  if (!found) throw StorageError(fmt::format("store {}: it has no model {}", path_, row));
  return *found;
}

std::string StateStore::bytesOf(std::int64_t row) const {
  std::string bytes;
  std::string hash;
  bool is_there = false;
  {
    const std::lock_guard lock(mutex_);
    Statement model(*database_, "SELECT blob FROM models WHERE id = ?");
    model.with(row);
    while (model.step()) {
      hash = model.text(0);
      is_there = true;
    }
    Statement parts(*database_, "SELECT data FROM blob_parts WHERE hash = ? ORDER BY part");
    parts.with(hash);
    while (parts.step())
      bytes += parts.text(0);
  }
  if (!is_there) throw StorageError(fmt::format("store {}: it has no model {}", path_, row));
  if (hash.empty()) return {};  // made of settings alone
  if (hashOf(bytes) == hash) return bytes;
  throw StorageError(
      fmt::format("store {}: the bytes of model {} are not what they were", path_, row));
}

}  // namespace handgraft::server
