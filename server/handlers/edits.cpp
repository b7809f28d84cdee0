#include "server/handlers/edits.h"

#include "core/base/error.h"
#include "server/admission/rejection.h"
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

}  // namespace

v1::EditReply applyEdit(LiveSession& live, const v1::Edit& edit) {
  session::Session& session = live.session();
  requireBase(live, edit, session.revision());
  const session::Edit change = editFrom(edit.body());
  session::EditResult result = session.apply(change, live.solves());
  live.noteEdit({result.revision, session::describe(change), edit.client()});
  v1::EditReply reply;
  reply.revision(result.revision);
  reply.message(std::move(result.message));
  return reply;
}

}  // namespace handgraft::server
