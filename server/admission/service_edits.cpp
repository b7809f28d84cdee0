// Edits of sessions, and demonstrators' frames: applied in order, answered, then one fresh
// solve for all that were applied meanwhile; one that comes while a solve runs cuts it short.
#include <algorithm>
#include <utility>

#include <spdlog/spdlog.h>

#include "core/base/error.h"
#include "idl/check.h"
#include "server/admission/error_reply.h"
#include "server/admission/operations.h"
#include "server/admission/rejection.h"
#include "server/admission/service.h"
#include "server/handlers/edits.h"
#include "server/handlers/follow.h"
#include "server/handlers/motions.h"
#include "server/handlers/optimize.h"

namespace handgraft::server {

void Service::onEdit(v1::Edit edit, const Sender& sender) {
  v1::EditReply reply;
  reply.client(edit.client());
  reply.edit_id(edit.edit_id());
  reply.session_id(edit.session_id());
  if (!passes(reply, [&] {
        requireMeant(edit.server_id());
      }))
    return;
  const Asker asker{sender, edit.client()};
  const auto begun = edits_.begin(asker, edit.edit_id());
  if (begun.verdict == Edits::Verdict::kAnswered) bus_.publish(*begun.answer);
  if (begun.verdict == Edits::Verdict::kForgotten) {
    if (auto before = editBefore(asker, edit)) {  // done, and the store knows
      before->client(edit.client());
      before->edit_id(edit.edit_id());
      before->session_id(edit.session_id());
      before->server_id(server_id_);
      return bus_.publish(*before);
    }
    passes(reply, [&] {
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

std::optional<v1::EditReply> Service::editBefore(const Asker& asker,
                                                 const v1::Edit& edit) const {
  if (options_.state == nullptr) return std::nullopt;
  const auto kept = options_.state->edit(markOf(asker.sender, asker.client, edit.edit_id()));
  if (!kept) return std::nullopt;
  v1::EditReply reply;
  reply.revision(kept->revision);
  reply.message(kept->message);
  return reply;
}

void Service::dispatchEdit(const Asker& asker, const std::shared_ptr<const v1::Edit>& edit) {
  whenOpen(
      edit->session_id(),
      [this, asker, edit](const std::shared_ptr<LiveSession>& live) {
        live->expectEdit();
        const bool is_taken =
            live->strand().post([this, edit, asker, live, stops = live->stops()] {
              live->meetEdit();
              runEdit(live, asker, edit, stops);
            });
        if (is_taken) return;
        live->meetEdit();
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

void Service::onDemonstrator(v1::DemonstratorFrame frame) {
  std::shared_ptr<LiveSession> live;
  try {
    requireMeant(frame.server_id());
    live = sessions_.find(frame.session_id());
  } catch (const std::exception&) {
    return;  // nobody waits for an answer
  }
  live->touch();
  if (!live->putFrame(std::move(frame))) return;
  const bool is_taken = live->strand().post([live] {
    const std::optional<v1::DemonstratorFrame> newest = live->takeFrame();
    if (newest && live->state().phase() != v1::PHASE_CLOSED) followFrame(*live, *newest);
  });
  if (!is_taken) static_cast<void>(live->takeFrame());
}

void Service::runEdit(const std::shared_ptr<LiveSession>& live,
                      const Asker& asker,
                      const std::shared_ptr<const v1::Edit>& shared,
                      std::uint64_t stops) {
  if (live->is_asleep) return dispatchEdit(asker, shared);
  const v1::Edit& edit = *shared;
  v1::EditReply reply;
  try {
    if (live->state().phase() == v1::PHASE_CLOSED) {
      reject(v1::ERROR_NOT_FOUND, "session {} is not open", live->id());
    }
    idl::check(edit);
    const Mark by = markOf(asker.sender, asker.client, edit.edit_id());
    reply = applyEdit(*live, edit, workshop_.models, by);
  } catch (...) {
    refuseEdit(asker, edit, live->session().revision());
    if (!live->solve_is_queued && live->requests_cut_short == 0) live->tellRest();
    return;
  }
  // Where the machine is so busy that one edit's solve after the other is cut short, the next
  // gets more time, but no more than people hardly notice.
  constexpr int kMostForEdits = 4;
  live->solves_cut_short = std::min(live->solves_cut_short, kMostForEdits);
  live->unexplained = nullptr;
  live->queued_at_stops = stops;
  live->enterSoon(v1::PHASE_OPTIMIZING);
  // Who has the answer and asks for the session's state finds the edit there.
  answerEdit(asker, edit, std::move(reply));
  queueSolve(live);
}

void Service::refuseEdit(const Asker& asker, const v1::Edit& edit, std::uint64_t revision) {
  ErrorReply error = errorReplyOf(std::current_exception());
  v1::EditReply reply;
  reply.revision(revision);
  reply.error(error.code);
  reply.message(std::move(error.message));
  answerEdit(asker, edit, std::move(reply));
}

void Service::answerEdit(const Asker& asker, const v1::Edit& edit, v1::EditReply reply) {
  reply.client(edit.client());
  reply.edit_id(edit.edit_id());
  reply.session_id(edit.session_id());
  reply.server_id(server_id_);
  spdlog::debug("event=edit client={} id={} session={} revision={} error={} message={}",
                shortName(edit.client()), edit.edit_id(), edit.session_id(), reply.revision(),
                static_cast<unsigned>(reply.error()), handgraft::quoted(reply.message()));
  const std::size_t bytes = v1::EditReply::getCdrSerializedSize(reply);
  const auto kept = edits_.answer(asker, edit.edit_id(), std::move(reply), bytes);
  bus_.publish(*kept);
}

void Service::queueSolve(const std::shared_ptr<LiveSession>& live) {
  live->prepareSolids(live, pool_);  // edits may have brought in other models
  if (std::exchange(live->solve_is_queued, true)) return;
  live->strand().postFromTask([this, live] {
    live->solve_is_queued = false;
    if (live->state().phase() == v1::PHASE_CLOSED) return;
    live->asked_at_stops = live->queued_at_stops;
    try {
      live->solves().checkpoint();
      // Beside a motion the pose needs no search; its explanation waits until both are out.
      optimizeAfterEdit(*live, workshop_, live->solves());
      if (followsEdits(*live)) solveMotionAfterEdit(*live, workshop_, live->solves());
    } catch (const CutShort&) {
      queueSolve(live);  // behind the edit; if that is refused, the one before wants its answer
    } catch (...) {      // the session's state says so already; nobody waits for a reply
      const ErrorReply error = errorReplyOf(std::current_exception());
      spdlog::log(
          error.code == v1::ERROR_CANCELLED ? spdlog::level::debug : spdlog::level::info,
          "event=solve session={} error={} message={}", live->id(),
          static_cast<unsigned>(error.code), handgraft::quoted(error.message));
    }
  });
}

}  // namespace handgraft::server
