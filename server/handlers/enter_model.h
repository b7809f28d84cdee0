#pragma once

#include <memory>
#include <string>
#include <utility>

#include "idl/models.h"
#include "server/handlers/handler_context.h"
#include "server/handlers/persisted_models.h"
#include "server/store/model_store.h"

namespace handgraft::server {

/// Puts a model where sessions find it, and first where it outlives the server: `recipe()`
/// says what it is made of. The same content under the same name again changes nothing.
/// Errors: as ModelStore::add and StateStore::addModel.
template <class Model, class RecipeOf>
v1::ModelList enterModel(Model model,
                         HandlerContext& context,
                         const RequestKey& by,
                         const std::string& operation,
                         const RecipeOf& recipe) {
  const v1::ModelSummary summary = summaryOf(model);
  v1::ModelList reply;
  reply.models().push_back(summary);
  if (!context.models.lacks(summary.kind(), summary.name(), model.origin.content)) return reply;
  if (context.persisted_models != nullptr) {
    model.origin.row =
        context.persisted_models->keep(summary, model.origin, recipe(), by, operation);
  } else {
    model.origin.recipe = std::make_shared<const ModelRecipe>(recipe());
  }
  context.models.add(std::move(model));
  return reply;
}

}  // namespace handgraft::server
