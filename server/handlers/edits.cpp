#include "server/handlers/edits.h"

#include "server/convert.h"
#include "server/rejection.h"

namespace handgraft::server {

std::uint64_t applyEdit(LiveSession& live, const v1::Edit& edit) {
  session::Session& session = live.session();
  if (edit.base_revision() != 0 && edit.base_revision() != session.revision()) {
    reject(v1::ERROR_CONFLICT, "session {} is at revision {}, the edit was made on revision {}",
           live.id(), session.revision(), edit.base_revision());
  }
  session.apply(editFrom(edit.body()));
  live.enter(live.state().phase());
  return session.revision();
}

}  // namespace handgraft::server
