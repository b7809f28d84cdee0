#pragma once

#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/io/session_file.h"
#include "server/handlers/handler_context.h"
#include "server/sessions/live_session.h"

/// The models that a saved session holds, so that it opens where nobody has them.
namespace handgraft::server {

/// Whether a session's "hand NAME", "object NAME", "contacts NAME" or "motion NAME" stands for
/// a model.
bool isThere(const std::string& model, const ModelStore& models);

/// Those that a session rests on, whatever their names stand for by now, and those that these
/// rest on, but for built-in ones; each after what it rests on; not those with which they would
/// take more than 16 MiB. Of the session's strand.
std::vector<io::EmbeddedModel> embeddedModels(LiveSession& live, const HandlerContext& context);

/// Where the motion of a session that holds one came from. Of the session's strand.
Origin originOfMotion(LiveSession& live, const HandlerContext& context);

/// Puts those whose names are free where sessions find them. A name that stands for a model
/// already stays: whether it is the same one is seen when the session is opened.
/// Errors: InvalidInput naming the model for bytes that are none; as enterModel.
void takeUp(const std::vector<io::EmbeddedModel>& models,
            HandlerContext& context,
            const Progress& progress);

}  // namespace handgraft::server
