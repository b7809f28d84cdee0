#pragma once

#include "idl/edits.h"
#include "server/sessions/live_session.h"
#include "server/store/model_store.h"

namespace handgraft::server {

/// Applies an edit whole or not at all; revision and message of the reply. Of the session's
/// strand.
///
/// Errors: InvalidInput; Rejection (ERROR_CONFLICT) if the session has moved on since the
/// edit's base revision, naming what happened since; (ERROR_NOT_FOUND) for a model to swap to.
/// Where the session is kept, the edit is on disk, with its mark, when this returns:
/// StorageError, Rejection (ERROR_STORAGE) if that did not do, and it was not applied.
v1::EditReply applyEdit(LiveSession& live,
                        const v1::Edit& edit,
                        const ModelStore& models,
                        const RequestKey& by);

}  // namespace handgraft::server
