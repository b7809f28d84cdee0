#pragma once

#include "core/base/progress.h"
#include "idl/models.h"
#include "server/handlers/handler_context.h"

/// One file per subject: a request in, a reply out, the context or session by reference, no
/// transport in sight. Errors are exceptions (InvalidInput, Rejection, Cancelled); the service
/// turns them into replies.
namespace handgraft::server {

void putFile(const v1::PutFileRequest& request,
             const UploadStore::ClientId& client,
             HandlerContext& context);

v1::ModelList listModels(const HandlerContext& context);

/// With meshes a hand's skin is made if need be, which takes seconds. Without, the sites of a
/// hand that brings none are missing until somebody has used it.
v1::ModelDescription describeModel(const v1::DescribeModelRequest& request,
                                   const HandlerContext& context,
                                   const Progress& progress);

void unloadModel(const v1::ModelKey& key, HandlerContext& context, const RequestKey& by);

}  // namespace handgraft::server
