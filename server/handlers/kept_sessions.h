#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "core/base/progress.h"
#include "server/handlers/handler_context.h"

/// Sessions that outlive the server: written down as they go, opened again when somebody asks
/// for them. Where the server has no store on disk, none of this does anything.
namespace handgraft::server {

/// Writes a new session down, before anybody is told of it. Errors: as StateStore::addSession.
void keepSession(LiveSession& live,
                 HandlerContext& context,
                 const RequestKey& by,
                 const std::string& operation);

/// A session as it was told of last: same id, revision, history and pose, to the byte. It joins
/// none of the lists, and tells nobody. Errors: StorageError; those of its models.
std::shared_ptr<LiveSession> openKeptSession(std::uint64_t id,
                                             HandlerContext& context,
                                             const Progress& progress);

/// Has those who watch see the pose that stands; solves what no pose answers yet. Of the
/// session's strand.
void resumeKeptSession(LiveSession& live, HandlerContext& context);

/// What the session came to, and its text where its history since has grown long. Of the
/// session's strand, when nothing is in a hurry.
void keepState(LiveSession& live);

/// Its text, whatever came since. Of the strand. Errors: StorageError.
void keepText(LiveSession& live);

/// Takes it out of memory, once its text is kept. Of the strand; the session does nothing
/// afterwards.
void putToSleep(LiveSession& live, HandlerContext& context);

}  // namespace handgraft::server
