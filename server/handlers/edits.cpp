#include "server/handlers/edits.h"

#include <utility>
#include <variant>
#include <vector>

#include "core/base/error.h"
#include "core/io/session_file.h"
#include "server/base/rejection.h"
#include "server/handlers/motion_edits.h"
#include "server/messages/edit_messages.h"

namespace handgraft::server {

namespace {

/// A conflict is told, never merged in silence.
void requireBase(const LiveSession& live, const v1::Edit& edit, std::uint64_t revision) {
  if (edit.base_revision() == 0 || edit.base_revision() == revision) return;
  if (edit.base_revision() > revision) {
    reject(v1::ERROR_CONFLICT, "session {} is at revision {}; there is no revision {} yet",
           live.id(), revision, edit.base_revision());
  }
  const std::string since = live.editsSince(edit.base_revision(), edit.client());
  reject(v1::ERROR_CONFLICT,
         "session {} is at revision {}, the edit was made on revision {}{}{}", live.id(),
         revision, edit.base_revision(), since.empty() ? "" : "; since then ", since);
}

/// The model that an edit brings in, and its row; row 0: none, or a built-in one.
std::pair<v1::ModelKey, std::int64_t> broughtIn(const session::Edit& edit,
                                                const ModelStore& models) {
  v1::ModelKey key;
  if (const auto* hand = std::get_if<session::HandEdit>(&edit)) {
    key.kind(v1::MODEL_HAND);
    key.name(hand->name);
    return {key, models.hand(hand->name)->origin.row};
  }
  if (const auto* object = std::get_if<session::ObjectEdit>(&edit)) {
    key.kind(v1::MODEL_OBJECT);
    key.name(object->name);
    return {key, models.object(object->name)->origin.row};
  }
  return {key, 0};
}

void keepEdit(LiveSession& live,
              const session::LogEntry& entry,
              const session::EditResult& outcome,
              const ModelStore& models,
              const RequestKey& by) {
  SessionJournal& journal = *live.journal;
  std::vector<std::int64_t> rows;
  v1::ModelKey key;
  const auto& edit = std::get<session::Edit>(entry);
  const bool is_swap = std::holds_alternative<session::HandEdit>(edit) ||
                       std::holds_alternative<session::ObjectEdit>(edit);
  if (is_swap) {
    const auto [model, row] = broughtIn(edit, models);
    key = model;
    if (row != 0 && !journal.knows(key.kind(), key.name())) rows.push_back(row);
  }
  journal.keepEdit(io::entryText(entry), by, {live.id(), outcome.revision, outcome.message},
                   rows);
  if (is_swap) journal.names(key.kind(), key.name());
}

}  // namespace

v1::EditReply applyEdit(LiveSession& live,
                        const v1::Edit& edit,
                        const ModelStore& models,
                        const RequestKey& by) {
  session::Session& session = live.session();
  requireBase(live, edit, session.revision());
  session::Edit change = editFrom(edit.body());
  const auto when = edit.when().empty() ? timeOfWholeEdit(live, change) : edit.when().front();
  change = when ? timedEdit(live, *when, change) : wholeEdit(live, std::move(change));
  session::Session::Keep keep;
  if (live.journal) {
    keep = [&](const session::LogEntry& entry, const session::EditResult& outcome) {
      keepEdit(live, entry, outcome, models, by);
    };
  }
  session::EditResult result = session.apply(change, live.solves(), keep);
  live.noteEdit(
      {result.revision, session::describe(change, *session.hand().model), edit.client()});
  v1::EditReply reply;
  reply.revision(result.revision);
  reply.message(std::move(result.message));
  return reply;
}

}  // namespace handgraft::server
