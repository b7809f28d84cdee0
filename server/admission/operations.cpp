#include "server/admission/operations.h"

#include <fmt/format.h>

#include "core/base/error.h"
#include "idl/fields.h"
#include "idl/json.h"
#include "server/admission/rejection.h"
#include "server/handlers/export.h"
#include "server/handlers/load_model.h"
#include "server/handlers/models.h"
#include "server/handlers/motion_clock.h"
#include "server/handlers/motions.h"
#include "server/handlers/optimize.h"
#include "server/handlers/pose_contacts.h"
#include "server/handlers/saved_sessions.h"
#include "server/handlers/sessions.h"
#include "server/handlers/settings.h"
#include "server/handlers/suggest.h"
#include "server/handlers/sweep.h"
#include "server/handlers/transfer.h"
#include "server/handlers/variant.h"
#include "server/store/state_store.h"

namespace handgraft::server {

namespace {

/// Sets the member first, then the discriminator (idl/README.md).
template <class Set>
v1::ReplyBody bodyOf(v1::Operation operation, Set&& set) {
  v1::ReplyBody body;
  set(body);
  body._d(operation);
  return body;
}

Mark markOf(const v1::Request& request, const Sender& sender) {
  return server::markOf(sender, request.client(), request.request_id());
}

}  // namespace

Lane laneOf(v1::Operation operation) {
  switch (operation) {
    case v1::OP_CANCEL:
    case v1::OP_STOP_SOLVING:
      return Lane::kAtOnce;
    case v1::OP_NOTHING:
    case v1::OP_PUT_FILE:
    case v1::OP_LIST_MODELS:
    case v1::OP_UNLOAD_MODEL:
    case v1::OP_DESCRIBE_SESSION:
    case v1::OP_LIST_SESSIONS:
      return Lane::kQuick;
    case v1::OP_LOAD_MODEL:
    case v1::OP_DESCRIBE_MODEL:
    case v1::OP_OPEN_SESSION:
    case v1::OP_POSE_CONTACTS:
    case v1::OP_MAKE_VARIANT:
    case v1::OP_SWEEP:
    case v1::OP_LOAD_SESSION:
    case v1::OP_REPLAY:
      return Lane::kPool;
    case v1::OP_CLOSE_SESSION:
    case v1::OP_TRANSFER:
    case v1::OP_SUGGEST:
    case v1::OP_OPTIMIZE:
    case v1::OP_EXPORT:
    case v1::OP_SESSION_SETTINGS:
    case v1::OP_COMPARE:
    case v1::OP_SAVE_SESSION:
    case v1::OP_SOLVE_MOTION:
    case v1::OP_MOTION_FRAMES:
    case v1::OP_SET_CLOCK:
    case v1::OP_LINK_POSES:
      return Lane::kSession;
    case v1::OP_SHARE_SESSION:
      reject(v1::ERROR_UNSUPPORTED, "this server does not {} yet", nameOf(operation));
  }
  rejectInput("operation {} does not exist", static_cast<unsigned>(operation));
}

std::uint64_t sessionOf(const v1::RequestBody& body) {
  switch (body._d()) {
    case v1::OP_OPTIMIZE:
      return body.optimize().session_id();
    case v1::OP_EXPORT:
      return body.export_file().session_id();
    case v1::OP_SUGGEST:
      return body.suggest().session_id();
    case v1::OP_COMPARE:
      return body.compare().session_id();
    case v1::OP_SOLVE_MOTION:
      return body.solve_motion().session_id();
    case v1::OP_MOTION_FRAMES:
      return body.motion_frames().session_id();
    case v1::OP_SET_CLOCK:
      return body.clock().session_id();
    case v1::OP_LINK_POSES:
      return body.link_poses().session_id();
    default:
      return body.session().session_id();
  }
}

Mark markOf(const Sender& sender, const v1::ClientId& client, std::uint64_t number) {
  Mark mark;
  mark.asker.assign(sender.begin(), sender.end());
  mark.asker.append(client.begin(), client.end());
  mark.number = number;
  return mark;
}

bool leavesSomething(v1::Operation operation) {
  switch (operation) {
    case v1::OP_OPEN_SESSION:
    case v1::OP_LOAD_SESSION:
    case v1::OP_LOAD_MODEL:
    case v1::OP_POSE_CONTACTS:
    case v1::OP_MAKE_VARIANT:
    case v1::OP_CLOSE_SESSION:
    case v1::OP_UNLOAD_MODEL:
      return true;
    default:
      return false;
  }
}

std::optional<v1::ReplyBody> replyBefore(const v1::Request& request,
                                         const Sender& sender,
                                         const Workshop& workshop) {
  const v1::Operation operation = request.body()._d();
  if (workshop.state == nullptr || !leavesSomething(operation)) return std::nullopt;
  const auto kept = workshop.state->request(markOf(request, sender));
  if (!kept) return std::nullopt;
  switch (operation) {
    case v1::OP_OPEN_SESSION:
    case v1::OP_LOAD_SESSION: {
      v1::SessionKey key;
      key.session_id(static_cast<std::uint64_t>(kept->subject));
      return bodyOf(operation, [&](auto& reply) {
        reply.session(describeSession(key, workshop));
      });
    }
    case v1::OP_CLOSE_SESSION:
    case v1::OP_UNLOAD_MODEL:
      return nothingSaid(operation);
    default:
      return bodyOf(operation, [&](auto& reply) {
        v1::ModelList list;
        list.models().push_back(
            idl::fromJsonText<v1::ModelSummary>(workshop.state->model(kept->subject).summary));
        reply.models(list);
      });
  }
}

v1::ReplyBody nothingSaid(v1::Operation operation) {
  return bodyOf(operation, [](v1::ReplyBody& body) {
    body.nothing(v1::Nothing());
  });
}

v1::ReplyBody perform(const v1::Request& request,
                      const Sender& sender,
                      Workshop& workshop,
                      const Progress& progress) {
  const v1::RequestBody& body = request.body();
  const v1::Operation operation = body._d();
  const Mark by = markOf(request, sender);
  switch (operation) {
    case v1::OP_NOTHING:
      return nothingSaid(operation);
    case v1::OP_PUT_FILE:
      putFile(body.put_file(), sender, workshop);
      return nothingSaid(operation);
    case v1::OP_LIST_MODELS:
      return bodyOf(operation, [&](auto& reply) {
        reply.models(listModels(workshop));
      });
    case v1::OP_UNLOAD_MODEL:
      unloadModel(body.unload_model(), workshop, by);
      return nothingSaid(operation);
    case v1::OP_DESCRIBE_SESSION:
      return bodyOf(operation, [&](auto& reply) {
        reply.session(describeSession(body.session(), workshop));
      });
    case v1::OP_LIST_SESSIONS:
      return bodyOf(operation, [&](auto& reply) {
        reply.sessions(listSessions(workshop));
      });
    case v1::OP_LOAD_MODEL:
      return bodyOf(operation, [&](auto& reply) {
        reply.models(loadModel(body.load_model(), sender, workshop, by, progress));
      });
    case v1::OP_DESCRIBE_MODEL:
      return bodyOf(operation, [&](auto& reply) {
        reply.model(describeModel(body.describe_model(), workshop, progress));
      });
    case v1::OP_OPEN_SESSION:
      return bodyOf(operation, [&](auto& reply) {
        reply.session(openSession(body.open_session(), workshop, by, progress));
      });
    case v1::OP_POSE_CONTACTS:
      return bodyOf(operation, [&](auto& reply) {
        reply.models(contactsOfPose(body.pose_contacts(), workshop, by, progress));
      });
    case v1::OP_MAKE_VARIANT:
      return bodyOf(operation, [&](auto& reply) {
        reply.models(makeVariant(body.variant(), workshop, by));
      });
    case v1::OP_SWEEP:
      return bodyOf(operation, [&](auto& reply) {
        reply.sweep(sweepHand(body.sweep(), workshop, progress));
      });
    case v1::OP_LOAD_SESSION:
      return bodyOf(operation, [&](auto& reply) {
        reply.session(loadSession(body.load_session(), workshop, by, progress));
      });
    case v1::OP_REPLAY:
      return bodyOf(operation, [&](auto& reply) {
        reply.replay(replaySession(body.replay(), workshop, progress));
      });
    default:
      throw BrokenContract(fmt::format("{} is an operation of a session", nameOf(operation)));
  }
}

v1::ReplyBody perform(const v1::Request& request,
                      const Sender& sender,
                      LiveSession& live,
                      Workshop& workshop,
                      const Progress& progress) {
  const v1::RequestBody& body = request.body();
  const v1::Operation operation = body._d();
  if (live.state().phase() == v1::PHASE_CLOSED) {
    reject(v1::ERROR_NOT_FOUND, "session {} is not open", live.id());
  }
  switch (operation) {
    case v1::OP_CLOSE_SESSION:
      closeSession(live, workshop, markOf(request, sender));
      return nothingSaid(operation);
    case v1::OP_TRANSFER:
      return bodyOf(operation, [&](auto& reply) {
        reply.transfer(transferPatches(live, progress));
      });
    case v1::OP_SUGGEST:
      return bodyOf(operation, [&](auto& reply) {
        reply.suggest(suggestPlacements(live, body.suggest(), progress));
      });
    case v1::OP_OPTIMIZE:
      return bodyOf(operation, [&](auto& reply) {
        reply.solution(optimizePose(live, body.optimize(), workshop, progress));
      });
    case v1::OP_EXPORT:
      return bodyOf(operation, [&](auto& reply) {
        reply.exported_file(exportSession(live, body.export_file(), workshop, progress));
      });
    case v1::OP_SESSION_SETTINGS:
      return bodyOf(operation, [&](auto& reply) {
        reply.settings(sessionSettings(live));
      });
    case v1::OP_COMPARE:
      return bodyOf(operation, [&](auto& reply) {
        reply.compare(compareSnapshots(live, body.compare(), progress));
      });
    case v1::OP_SAVE_SESSION:
      return bodyOf(operation, [&](auto& reply) {
        reply.saved_session(saveSession(live, workshop));
      });
    case v1::OP_SOLVE_MOTION:
      return bodyOf(operation, [&](auto& reply) {
        reply.motion(solveMotion(live, body.solve_motion(), workshop, progress));
      });
    case v1::OP_MOTION_FRAMES:
      return bodyOf(operation, [&](auto& reply) {
        reply.motion_frames(motionFrames(live, body.motion_frames()));
      });
    case v1::OP_SET_CLOCK:
      return bodyOf(operation, [&](auto& reply) {
        reply.clock(setClock(live, body.clock(), request.client()));
      });
    case v1::OP_LINK_POSES:
      return bodyOf(operation, [&](auto& reply) {
        reply.link_poses(linkPoses(live, body.link_poses()));
      });
    default:
      throw BrokenContract(fmt::format("{} is no operation of a session", nameOf(operation)));
  }
}

}  // namespace handgraft::server
