#include "server/handlers/saved_sessions.h"

#include <chrono>
#include <optional>
#include <utility>

#include "core/base/error.h"
#include "core/io/session_file.h"
#include "core/session/replay.h"
#include "server/base/rejection.h"
#include "server/handlers/embedded_models.h"
#include "server/handlers/motions.h"
#include "server/handlers/optimize.h"
#include "server/handlers/sessions.h"
#include "server/store/model_source.h"

namespace handgraft::server {

namespace {

/// All that is lacking at once. Errors: Rejection (ERROR_NOT_FOUND).
void requireThere(const io::SessionFile& file, const ModelStore& models) {
  std::string missing;
  for (const auto& [named, hash] : file.hashes) {
    const bool is_motion = !file.motion.name.empty() && named == "contacts " + file.motion.name;
    const std::string model = is_motion ? "motion " + file.motion.name : named;
    if (isThere(model, models)) continue;
    missing += (missing.empty() ? "" : ", ") + model;
  }
  if (missing.empty()) return;
  reject(v1::ERROR_NOT_FOUND,
         "the session rests on what this server does not have and the file does not hold: {}; "
         "load it under these names first",
         missing);
}

session::SessionModels modelsOf(const io::SessionFile& file,
                                HandlerContext& context,
                                const Progress& progress) {
  takeUp(file.held, context, progress);
  requireThere(file, context.models);
  if (!file.motion.name.empty()) {
    const auto motion = context.models.motion(file.motion.name);
    if (motion->origin.content != file.motion.content) {
      rejectInput("session: motion {} is another one than it was saved with",
                  handgraft::quoted(file.motion.name));
    }
    return motionModels(file.hand, file.object, file.motion.name, context.models,
                        sourceOf(context.models), progress);
  }
  return sessionModels(file.hand, file.object, file.contacts, context.models,
                       sourceOf(context.models), progress);
}

}  // namespace

namespace {

/// The motion as it was when the session was opened, whoever has its name by now.
io::MotionOfSession motionToSave(LiveSession& live, const HandlerContext& context) {
  if (live.motion() == nullptr) return {};
  return {live.motion()->name, originOfMotion(live, context).content};
}

}  // namespace

v1::SaveSessionReply saveSession(LiveSession& live, const HandlerContext& context) {
  v1::SaveSessionReply reply;
  reply.text(io::sessionText(live.session(), embeddedModels(live, context),
                             motionToSave(live, context)));
  return reply;
}

v1::SessionState loadSession(const v1::LoadSessionRequest& request,
                             HandlerContext& context,
                             const RequestKey& by,
                             const Progress& progress) {
  const io::SessionFile file = io::readSessionText(request.text());
  const auto begin = std::chrono::steady_clock::now();
  session::SessionModels models = modelsOf(file, context, progress);
  const std::chrono::duration<double, std::milli> skin =
      std::chrono::steady_clock::now() - begin;
  std::optional<LiveMotion> motion;
  if (!file.motion.name.empty()) {
    motion = LiveMotion{file.motion.name, context.models.motion(file.motion.name)->motion,
                        models.object_O};
  }
  const auto live =
      enterSession(io::openSession(file, std::move(models), progress), skin.count(), context,
                   by, "load_session", progress, std::move(motion));
  for (const session::LogEntry& entry : file.session.log)
    if (const auto* followed = std::get_if<session::FollowedMotion>(&entry))
      resumeFollowing(*live, *followed);
  // Those who watch see the pose that was saved; if not now, after the next edit.
  static_cast<void>(live->strand().post([live, &context] {
    if (!followsEdits(*live) && !live->session().document().start_is_known) return;
    solveAfterOpening(*live, context);
  }));
  return live->state();
}

v1::ReplayReply replaySession(const v1::ReplayRequest& request,
                              HandlerContext& context,
                              const Progress& progress) {
  const io::SessionFile file = io::readSessionText(request.text());
  const session::SessionModels models = modelsOf(file, context, progress);
  io::requireSameModels(file, models, progress);
  session::Replay replay = session::replay(models, file.session, false, progress);
  v1::ReplayReply reply;
  reply.entries(static_cast<std::uint32_t>(replay.entries));
  reply.same(replay.same);
  reply.message(replay.message);
  reply.result().text(io::sessionText(replay.session, file.held, file.motion));
  return reply;
}

}  // namespace handgraft::server
