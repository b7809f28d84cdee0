// Edits of sessions, and demonstrators' frames: applied in order, answered, then one fresh
// solve for all that were applied meanwhile; one that comes while a solve runs cuts it short.
#include <utility>

#include "core/base/error.h"
#include "idl/check.h"
#include "server/admission/error_reply.h"
#include "server/admission/service.h"
#include "server/base/rejection.h"
#include "server/handlers/edits.h"
#include "server/handlers/follow.h"
#include "server/handlers/optimize.h"
#include "server/log/log.h"

namespace handgraft::server {

void Service::onEdit(v1::Edit edit, const Sender& sender) {
  v1::EditReply reply;
  reply.client(edit.client());
  reply.edit_id(edit.edit_id());
  reply.session_id(edit.session_id());
  if (!passes(reply, sender, [&] {
        requireMeant(edit.server_id());
      }))
    return;
  const RequestOrigin asker{sender, edit.client()};
  const auto begun = edits_.begin(asker, edit.edit_id());
  if (begun.verdict == Edits::Verdict::kAnswered) bus_.publish(*begun.answer, sender);
  if (begun.verdict == Edits::Verdict::kForgotten) {
    if (auto before = editBefore(asker, edit)) {  // done, and the store knows
      before->client(edit.client());
      before->edit_id(edit.edit_id());
      before->session_id(edit.session_id());
      before->server_id(server_id_);
      return bus_.publish(*before, sender);
    }
    passes(reply, sender, [&] {
      rejectForgotten("edit", reply.edit_id());
    });
  }
  if (begun.verdict != Edits::Verdict::kNew) return;
  const auto shared = std::make_shared<const v1::Edit>(std::move(edit));
  try {
    if (const auto before = editBefore(asker, *shared))
      return answerEdit(asker, *shared, *before);
    dispatchEdit(asker, shared);
  } catch (...) {
    refuseEdit(asker, *shared, 0);
  }
}

std::optional<v1::EditReply> Service::editBefore(const RequestOrigin& asker,
                                                 const v1::Edit& edit) const {
  if (options_.state == nullptr) return std::nullopt;
  const auto kept =
      options_.state->edit(requestKeyOf(asker.sender, asker.client, edit.edit_id()));
  if (!kept) return std::nullopt;
  v1::EditReply reply;
  reply.revision(kept->revision);
  reply.message(kept->message);
  return reply;
}

void Service::dispatchEdit(const RequestOrigin& asker,
                           const std::shared_ptr<const v1::Edit>& edit) {
  whenOpen(
      edit->session_id(),
      [this, asker, edit](const std::shared_ptr<LiveSession>& live) {
        requireMaySteer(live->access(), bus_.whoIs(asker.sender), live->id());
        live->touch();
        live->cycle().editQueued();
        const bool is_taken =
            live->strand().postShort([this, edit, asker, live, asked = live->cycle().asked()] {
              live->cycle().editTaken();
              runEdit(live, asker, edit, asked);
            });
        if (is_taken) return;
        live->cycle().editTaken();
        reject(v1::ERROR_OVERLOADED, "too many edits of session {} wait; try later",
               live->id());
      },
      [this, asker, edit](const std::exception_ptr& trouble) {
        try {
          std::rethrow_exception(trouble);
        } catch (...) {
          refuseEdit(asker, *edit, 0);
        }
      });
}

// === Demonstrators: a frame is answered by a pose; one that the next overtakes is not

void Service::onDemonstrator(v1::DemonstratorFrame frame, const Sender& sender) {
  std::shared_ptr<LiveSession> live;
  try {
    requireMeant(frame.server_id());
    live = sessions_.find(frame.session_id());
    requireMaySteer(live->access(), bus_.whoIs(sender), live->id());
  } catch (const std::exception&) {
    return;  // nobody waits for an answer
  }
  live->touch();
  if (!live->putFrame(std::move(frame))) return;
  const bool is_taken = live->strand().postShort([this, live] {
    const std::optional<v1::DemonstratorFrame> newest = live->takeFrame();
    if (newest && !live->isClosed()) followFrame(*live, context_.models, *newest);
  });
  if (!is_taken) static_cast<void>(live->takeFrame());
}

void Service::runEdit(const std::shared_ptr<LiveSession>& live,
                      const RequestOrigin& asker,
                      const std::shared_ptr<const v1::Edit>& shared,
                      SolveCycle::StopEpoch asked) {
  if (live->is_asleep) return dispatchEdit(asker, shared);
  const v1::Edit& edit = *shared;
  v1::EditReply reply;
  try {
    if (live->isClosed()) reject(v1::ERROR_NOT_FOUND, "session {} is not open", live->id());
    idl::check(edit);
    const RequestKey by = requestKeyOf(asker.sender, asker.client, edit.edit_id());
    reply = applyEdit(*live, edit, context_.models, by);
  } catch (...) {
    refuseEdit(asker, edit, live->session().revision());
    if (!live->cycle().isAwaited()) live->tellRest();
    return;
  }
  const bool is_first = live->cycle().editApplied(asked);
  live->enterSoon(v1::PHASE_OPTIMIZING);
  // Who has the answer and asks for the session's state finds the edit there.
  answerEdit(asker, edit, std::move(reply));
  live->prepareSolids(live, pool_);  // edits may have brought in other models
  if (is_first) queueSolve(live);
}

void Service::refuseEdit(const RequestOrigin& asker,
                         const v1::Edit& edit,
                         std::uint64_t revision) {
  ErrorReply error = errorReplyOf(std::current_exception());
  v1::EditReply reply;
  reply.revision(revision);
  reply.error(error.code);
  reply.message(std::move(error.message));
  answerEdit(asker, edit, std::move(reply));
}

void Service::answerEdit(const RequestOrigin& asker,
                         const v1::Edit& edit,
                         v1::EditReply reply) {
  reply.client(edit.client());
  reply.edit_id(edit.edit_id());
  reply.session_id(edit.session_id());
  reply.server_id(server_id_);
  log::debug("event=edit client={} id={} session={} revision={} error={} message={}",
             shortName(edit.client()), edit.edit_id(), edit.session_id(), reply.revision(),
             static_cast<unsigned>(reply.error()), handgraft::quoted(reply.message()));
  const std::size_t bytes = v1::EditReply::getCdrSerializedSize(reply);
  const auto kept = edits_.answer(asker, edit.edit_id(), std::move(reply), bytes);
  bus_.publish(*kept, asker.sender);
}

void Service::queueSolve(const std::shared_ptr<LiveSession>& live) {
  live->strand().postBehindShortFromTask([this, live] {
    live->cycle().takePending();
    if (live->isClosed() || live->solves().cancelled()) return;
    try {
      const SolveEnd end = solveAfterEdit(*live, context_);
      log::debug("event=solve session={} end={}", live->id(), nameOf(end));
      // Behind the edit: if that is refused, the one before wants its answer.
      if (end == SolveEnd::kCutShort && live->cycle().solveAgain()) queueSolve(live);
    } catch (...) {  // the session's state says so already; nobody waits for a reply
      const ErrorReply error = errorReplyOf(std::current_exception());
      log::info("event=solve session={} error={} message={}", live->id(),
                static_cast<unsigned>(error.code), handgraft::quoted(error.message));
    }
  });
}

}  // namespace handgraft::server
