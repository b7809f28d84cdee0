#include "server/handlers/models.h"

#include <utility>

#include "core/base/error.h"
#include "server/messages/descriptions.h"
#include "server/store/state_store.h"

namespace handgraft::server {

void putFile(const v1::PutFileRequest& request,
             const UploadStore::ClientId& client,
             Workshop& workshop) {
  workshop.uploads.put(client, request);
}

v1::ModelList listModels(const Workshop& workshop) {
  v1::ModelList reply;
  reply.models(workshop.models.list());
  return reply;
}

v1::ModelDescription describeModel(const v1::DescribeModelRequest& request,
                                   const Workshop& workshop,
                                   const Progress& progress) {
  v1::ModelDescription reply;
  const std::string& name = request.model().name();
  switch (request.model().kind()) {
    case v1::MODEL_HAND: {
      const auto hand = workshop.models.hand(name);
      std::optional<SkinnedHand> skinned;
      if (request.with_meshes())
        skinned = {hand->hand->get(progress), hand->hand->skinReport(progress)};
      reply.hand(describe(*hand, skinned));
      return reply;
    }
    case v1::MODEL_OBJECT:
      reply.object(describe(*workshop.models.object(name), request.with_meshes()));
      return reply;
    case v1::MODEL_CONTACTS:
      reply.contacts(describe(*workshop.models.contacts(name), request.with_meshes()));
      return reply;
    case v1::MODEL_MOTION:
      reply.motion(describe(*workshop.models.motion(name), request.with_meshes()));
      return reply;
  }
  rejectInput("model kind {} does not exist", static_cast<unsigned>(request.model().kind()));
}

void unloadModel(const v1::ModelKey& key, Workshop& workshop, const Mark& by) {
  workshop.models.requireRemovable(key.kind(), key.name());
  if (workshop.state != nullptr)
    workshop.state->removeModel(static_cast<int>(key.kind()), key.name(), by, "unload_model");
  workshop.models.remove(key.kind(), key.name());
}

}  // namespace handgraft::server
