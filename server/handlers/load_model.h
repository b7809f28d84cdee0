#pragma once

#include "core/base/progress.h"
#include "idl/models.h"
#include "server/handlers/handler_context.h"

namespace handgraft::server {

/// The summary of the model that was read, by a process of its own (upload_reader.h). The
/// upload is gone afterwards, also after an error. The same files read in the same way under
/// the same name change nothing.
///
/// Errors: as UploadReader::read, with ERROR_UNITS for UnitsInDoubt; InvalidInput for options
/// out of range, files that were not sent, contacts without an object; as ModelStore::add.
v1::ModelList loadModel(const v1::LoadModelRequest& request,
                        const UploadStore::ClientId& client,
                        HandlerContext& context,
                        const RequestKey& by,
                        const Progress& progress);

}  // namespace handgraft::server
