#include "server/handlers/sessions.h"

#include <chrono>
#include <optional>
#include <utility>

#include "core/base/error.h"
#include "server/handlers/kept_sessions.h"
#include "server/messages/convert.h"
#include "server/messages/transfer_messages.h"
#include "server/store/model_source.h"

namespace handgraft::server {

v1::SessionState openSession(const v1::OpenSessionRequest& request,
                             HandlerContext& context,
                             const RequestKey& by,
                             const Progress& progress) {
  const Pose X_WO = poseFrom(request.X_WO(), "X_WO");
  const optimize::Weights weights = weightsFrom(request.weights());
  const transfer::TransferOptions transfer = transferOptionsFrom(request.transfer());

  const auto begin = std::chrono::steady_clock::now();
  if (!request.contacts().empty() && !request.motion().empty()) {
    rejectInput("contacts {} and motion {}: a session holds one of them",
                handgraft::quoted(request.contacts()), handgraft::quoted(request.motion()));
  }
  if (!request.motion().empty() && !request.X_WO().empty()) {
    rejectInput(
        "X_WO: motion {} tells where its object is; only a session of contacts places it",
        handgraft::quoted(request.motion()));
  }
  std::optional<LiveMotion> motion;
  if (!request.motion().empty()) {
    motion =
        LiveMotion{request.motion(), context.models.motion(request.motion())->motion, nullptr};
  }
  session::SessionModels models =
      motion ? motionModels(request.hand(), request.object(), request.motion(), context.models,
                            sourceOf(context.models), progress)
             : sessionModels(request.hand(), request.object(), request.contacts(),
                             context.models, sourceOf(context.models), progress);
  const std::chrono::duration<double, std::milli> skin =
      std::chrono::steady_clock::now() - begin;
  if (motion) motion->object_O = models.object_O;
  const HandlerContext::Share share(context);
  models.threads = share.threads();
  return enterSession(session::Session(std::move(models), X_WO, weights, transfer, progress),
                      skin.count(), context, by, "open_session", progress, std::move(motion))
      ->state();
}

std::shared_ptr<LiveSession> enterSession(session::Session session,
                                          double skin_ms,
                                          HandlerContext& context,
                                          const RequestKey& by,
                                          const std::string& operation,
                                          const Progress& progress,
                                          std::optional<LiveMotion> motion) {
  progress.checkpoint();
  auto live = std::make_shared<LiveSession>(context.sessions.reserve(), std::move(session),
                                            context.pool, context.audience);
  live->belongTo(context.sessions.serverId());
  live->grant(accessOfNew(by.who), PublishedState::kSilently);
  if (motion) live->hold(std::move(*motion));
  live->took.skin_ms = skin_ms;
  keepSession(*live, context, by, operation);
  live->prepareSolids(live, context.pool);
  context.sessions.add(live);
  live->enter(v1::PHASE_OPEN);
  return live;
}

v1::SessionState describeSession(const v1::SessionKey& key, const HandlerContext& context) {
  if (auto state = context.sessions.asleep(key.session_id())) return *std::move(state);
  return context.sessions.find(key.session_id())->state();
}

v1::SessionList listSessions(const HandlerContext& context) {
  v1::SessionList reply;
  reply.sessions(context.sessions.states());
  return reply;
}

void closeSession(LiveSession& live,
                  HandlerContext& context,
                  const RequestKey& by,
                  const std::string& why) {
  if (live.journal) live.journal->store().removeSession(live.id(), by, "close_session");
  live.journal = nullptr;
  context.sessions.remove(live.id());
  live.enter(v1::PHASE_CLOSED, why);
}

}  // namespace handgraft::server
