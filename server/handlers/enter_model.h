#pragma once

#include <memory>
#include <string>
#include <utility>

#include "idl/models.h"
#include "server/admission/workshop.h"
#include "server/handlers/kept_models.h"
#include "server/store/model_store.h"

namespace handgraft::server {

/// Puts a model where sessions find it, and first where it outlives the server: `makings()`
/// says what it is made of. The same content under the same name again changes nothing.
/// Errors: as ModelStore::add and StateStore::addModel.
template <class Model, class MakingsOf>
v1::ModelList enterModel(Model model,
                         Workshop& workshop,
                         const Mark& by,
                         const std::string& operation,
                         const MakingsOf& makings) {
  const v1::ModelSummary summary = summaryOf(model);
  v1::ModelList reply;
  reply.models().push_back(summary);
  if (!workshop.models.lacks(summary.kind(), summary.name(), model.origin.content))
    return reply;
  if (workshop.kept_models != nullptr) {
    model.origin.row =
        workshop.kept_models->keep(summary, model.origin, makings(), by, operation);
  } else {
    model.origin.makings = std::make_shared<const Makings>(makings());
  }
  workshop.models.add(std::move(model));
  return reply;
}

}  // namespace handgraft::server
