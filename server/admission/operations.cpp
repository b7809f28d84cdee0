#include "server/admission/operations.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "core/base/error.h"
#include "idl/fields.h"
#include "idl/json.h"
#include "server/base/rejection.h"
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
#include "server/handlers/sharing.h"
#include "server/handlers/suggest.h"
#include "server/handlers/sweep.h"
#include "server/handlers/transfer.h"
#include "server/handlers/variant.h"

namespace handgraft::server {

namespace {

/// What the store remembers that an operation left behind, and its reply is made of when it is
/// asked for again.
enum class Leaves { kNothing, kSession, kModel, kItsEnd };

using Body = v1::ReplyBody;

/// Fills the reply, whose discriminator is set afterwards. False: cut short by an edit.
using Handler = bool (*)(const Call& call, Body& reply);

struct Rule {
  v1::Operation operation;
  Lane lane;
  Leaves leaves;
  Handler handle;
};

/// Of handlers that are always done.
template <auto kHandle>
constexpr Handler kDone = [](const Call& call, Body& reply) {
  kHandle(call, reply);
  return true;
};

/// Sets the reply if there is one.
template <class Value, class Set>
bool setIfAny(std::optional<Value> value, const Set& set) {
  if (!value) return false;
  set(*std::move(value));
  return true;
}

constexpr auto kNothing = kDone<[](const Call&, Body&) {}>;

// clang-format off
constexpr Rule kRules[] = {
    {v1::OP_NOTHING, Lane::kQuick, Leaves::kNothing, kNothing},
    // Of the service itself.
    {v1::OP_CANCEL, Lane::kAtOnce, Leaves::kNothing, kNothing},
    {v1::OP_STOP_SOLVING, Lane::kAtOnce, Leaves::kNothing, kNothing},

    {v1::OP_PUT_FILE, Lane::kQuick, Leaves::kNothing, kDone<[](const Call& c, Body&) {
       putFile(c.body().put_file(), c.sender, c.context);
     }>},
    {v1::OP_LOAD_MODEL, Lane::kPool, Leaves::kModel, kDone<[](const Call& c, Body& reply) {
       reply.models(loadModel(c.body().load_model(), c.sender, c.context, c.requestKey(), c.progress));
     }>},
    {v1::OP_LIST_MODELS, Lane::kQuick, Leaves::kNothing, kDone<[](const Call& c, Body& reply) {
       reply.models(listModels(c.context));
     }>},
    {v1::OP_DESCRIBE_MODEL, Lane::kPool, Leaves::kNothing, kDone<[](const Call& c, Body& reply) {
       reply.model(describeModel(c.body().describe_model(), c.context, c.progress));
     }>},
    {v1::OP_UNLOAD_MODEL, Lane::kQuick, Leaves::kItsEnd, kDone<[](const Call& c, Body&) {
       unloadModel(c.body().unload_model(), c.context, c.requestKey());
     }>},
    {v1::OP_POSE_CONTACTS, Lane::kPool, Leaves::kModel, kDone<[](const Call& c, Body& reply) {
       reply.models(contactsOfPose(c.body().pose_contacts(), c.context, c.requestKey(), c.progress));
     }>},
    {v1::OP_MAKE_VARIANT, Lane::kPool, Leaves::kModel, kDone<[](const Call& c, Body& reply) {
       reply.models(makeVariant(c.body().variant(), c.context, c.requestKey()));
     }>},
    {v1::OP_SWEEP, Lane::kPool, Leaves::kNothing, kDone<[](const Call& c, Body& reply) {
       reply.sweep(sweepHand(c.body().sweep(), c.context, c.progress));
     }>},

    {v1::OP_OPEN_SESSION, Lane::kPool, Leaves::kSession, kDone<[](const Call& c, Body& reply) {
       reply.session(openSession(c.body().open_session(), c.context, c.requestKey(), c.progress));
     }>},
    {v1::OP_LOAD_SESSION, Lane::kPool, Leaves::kSession, kDone<[](const Call& c, Body& reply) {
       reply.session(loadSession(c.body().load_session(), c.context, c.requestKey(), c.progress));
     }>},
    {v1::OP_REPLAY, Lane::kPool, Leaves::kNothing, kDone<[](const Call& c, Body& reply) {
       reply.replay(replaySession(c.body().replay(), c.context, c.progress));
     }>},
    {v1::OP_DESCRIBE_SESSION, Lane::kQuick, Leaves::kNothing, kDone<[](const Call& c, Body& reply) {
       reply.session(describeSession(c.body().session(), c.context));
     }>},
    {v1::OP_LIST_SESSIONS, Lane::kQuick, Leaves::kNothing, kDone<[](const Call& c, Body& reply) {
       reply.sessions(listSessions(c.context));
     }>},
    {v1::OP_CLOSE_SESSION, Lane::kSession, Leaves::kItsEnd, kDone<[](const Call& c, Body&) {
       closeSession(c.live(), c.context, c.requestKey());
     }>},
    {v1::OP_SESSION_SETTINGS, Lane::kSession, Leaves::kNothing, kDone<[](const Call& c, Body& reply) {
       reply.settings(sessionSettings(c.live()));
     }>},
    {v1::OP_SAVE_SESSION, Lane::kSession, Leaves::kNothing, kDone<[](const Call& c, Body& reply) {
       reply.saved_session(saveSession(c.live(), c.context));
     }>},

    {v1::OP_TRANSFER, Lane::kSession, Leaves::kNothing, kDone<[](const Call& c, Body& reply) {
       reply.transfer(transferPatches(c.live(), c.progress));
     }>},
    {v1::OP_SUGGEST, Lane::kSession, Leaves::kNothing, kDone<[](const Call& c, Body& reply) {
       reply.suggest(suggestPlacements(c.live(), c.body().suggest(), c.progress));
     }>},
    {v1::OP_COMPARE, Lane::kSession, Leaves::kNothing, kDone<[](const Call& c, Body& reply) {
       reply.compare(compareSnapshots(c.live(), c.body().compare(), c.progress));
     }>},
    {v1::OP_OPTIMIZE, Lane::kSession, Leaves::kNothing, [](const Call& c, Body& reply) {
       return setIfAny(optimizePose(c.live(), c.body().optimize(), c.context, c.progress),
                       [&](v1::PoseSolution&& solution) { reply.solution(std::move(solution)); });
     }},
    {v1::OP_EXPORT, Lane::kSession, Leaves::kNothing, [](const Call& c, Body& reply) {
       return setIfAny(exportSession(c.live(), c.body().export_file(), c.context, c.progress),
                       [&](v1::ExportReply&& file) { reply.exported_file(std::move(file)); });
     }},

    {v1::OP_SOLVE_MOTION, Lane::kSession, Leaves::kNothing, kDone<[](const Call& c, Body& reply) {
       reply.motion(solveMotion(c.live(), c.body().solve_motion(), c.context, c.progress));
     }>},
    {v1::OP_MOTION_FRAMES, Lane::kSession, Leaves::kNothing, kDone<[](const Call& c, Body& reply) {
       reply.motion_frames(motionFrames(c.live(), c.body().motion_frames()));
     }>},
    {v1::OP_SET_CLOCK, Lane::kSession, Leaves::kNothing, kDone<[](const Call& c, Body& reply) {
       reply.clock(setClock(c.live(), c.body().clock(), c.request.client()));
     }>},
    {v1::OP_LINK_POSES, Lane::kSession, Leaves::kNothing, kDone<[](const Call& c, Body& reply) {
       reply.link_poses(linkPoses(c.live(), c.body().link_poses()));
     }>},
    {v1::OP_SHARE_SESSION, Lane::kSession, Leaves::kNothing, kDone<[](const Call& c, Body& reply) {
       reply.session(shareSession(c.live(), c.body().share(), c.who()));
     }>},
};

// clang-format on

/// Errors: Rejection (ERROR_UNSUPPORTED), InvalidInput for one that does not exist.
const Rule& ruleOf(v1::Operation operation) {
  const auto* const found =
      std::find_if(std::begin(kRules), std::end(kRules), [&](const Rule& rule) {
        return rule.operation == operation;
      });
  if (found != std::end(kRules)) return *found;
  if (idl::chosenOf(idl::typeOf<v1::RequestBody>(), static_cast<std::uint32_t>(operation)))
    reject(v1::ERROR_UNSUPPORTED, "this server does not {} yet", nameOf(operation));
  rejectInput("operation {} does not exist", static_cast<unsigned>(operation));
}

/// To be filled: the member first, then the discriminator (idl/README.md).
Body emptyBody() {
  Body body;
  body.nothing(v1::Nothing());
  return body;
}

}  // namespace

Lane laneOf(v1::Operation operation) {
  return ruleOf(operation).lane;
}

RequestKey Call::requestKey() const {
  RequestKey request_key = requestKeyOf(sender, request.client(), request.request_id());
  request_key.who = who();
  return request_key;
}

Who Call::who() const {
  return context.bus == nullptr ? Who() : context.bus->whoIs(sender);
}

RequestKey requestKeyOf(const Sender& sender,
                        const v1::ClientId& client,
                        std::uint64_t number) {
  RequestKey request_key;
  request_key.asker.assign(sender.begin(), sender.end());
  request_key.asker.append(client.begin(), client.end());
  request_key.number = number;
  return request_key;
}

std::optional<Body> replyBefore(const Call& call) {
  const v1::Operation operation = call.body()._d();
  const Leaves leaves = ruleOf(operation).leaves;
  if (call.context.state == nullptr || leaves == Leaves::kNothing) return std::nullopt;
  const auto kept = call.context.state->request(call.requestKey());
  if (!kept) return std::nullopt;
  Body reply = emptyBody();
  if (leaves == Leaves::kSession) {
    v1::SessionKey key;
    key.session_id(static_cast<std::uint64_t>(kept->subject));
    reply.session(describeSession(key, call.context));
  } else if (leaves == Leaves::kModel) {
    v1::ModelList list;
    list.models().push_back(
        idl::fromJsonText<v1::ModelSummary>(call.context.state->model(kept->subject).summary));
    reply.models(list);
  }
  reply._d(operation);
  return reply;
}

Body nothingSaid(v1::Operation operation) {
  Body reply = emptyBody();
  reply._d(operation);
  return reply;
}

std::optional<Body> perform(const Call& call) {
  if (call.session != nullptr && call.session->isClosed())
    reject(v1::ERROR_NOT_FOUND, "session {} is not open", call.session->id());
  const v1::Operation operation = call.body()._d();
  Body reply = emptyBody();
  if (!ruleOf(operation).handle(call, reply)) return std::nullopt;
  reply._d(operation);
  return reply;
}

}  // namespace handgraft::server
