#include "server/handlers/models.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "server/messages/descriptions.h"
#include "server/store/state_store.h"

namespace handgraft::server {

namespace {

bool isInASession(const std::string& hand, const SessionStore& sessions) {
  const std::vector<v1::SessionState> states = sessions.states();
  return std::any_of(states.begin(), states.end(), [&](const v1::SessionState& state) {
    return state.hand() == hand;
  });
}

}  // namespace

void putFile(const v1::PutFileRequest& request,
             const UploadStore::ClientId& client,
             HandlerContext& context) {
  context.uploads.put(client, request);
}

v1::ModelList listModels(const HandlerContext& context) {
  v1::ModelList reply;
  reply.models(context.models.list());
  return reply;
}

v1::ModelDescription describeModel(const v1::DescribeModelRequest& request,
                                   const HandlerContext& context,
                                   const Progress& progress) {
  v1::ModelDescription reply;
  const std::string& name = request.model().name();
  switch (request.model().kind()) {
    case v1::MODEL_HAND: {
      const auto hand = context.models.hand(name);
      std::optional<SkinnedHand> skinned;
      if (request.with_meshes()) {
        skinned = {hand->hand->get(progress), hand->hand->skinReport(progress)};
      } else if (isInASession(name, context.sessions)) {
        // The session opened with its skin and sites, perhaps in the server before this one.
        static_cast<void>(hand->hand->get(progress));
      }
      reply.hand(describe(*hand, skinned));
      return reply;
    }
    case v1::MODEL_OBJECT:
      reply.object(describe(*context.models.object(name), request.with_meshes()));
      return reply;
    case v1::MODEL_CONTACTS:
      reply.contacts(describe(*context.models.contacts(name), request.with_meshes()));
      return reply;
    case v1::MODEL_MOTION:
      reply.motion(describe(*context.models.motion(name), request.with_meshes()));
      return reply;
  }
  rejectInput("model kind {} does not exist", static_cast<unsigned>(request.model().kind()));
}

void unloadModel(const v1::ModelKey& key, HandlerContext& context, const RequestKey& by) {
  context.models.requireRemovable(key.kind(), key.name());
  if (context.state != nullptr)
    context.state->removeModel(static_cast<int>(key.kind()), key.name(), by, "unload_model");
  context.models.remove(key.kind(), key.name());
}

}  // namespace handgraft::server
