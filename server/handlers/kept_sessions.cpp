#include "server/handlers/kept_sessions.h"

#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/io/session_file.h"
#include "idl/json.h"
#include "server/handlers/motions.h"
#include "server/handlers/optimize.h"
#include "server/handlers/persisted_models.h"
#include "server/log/log.h"
#include "server/store/model_source.h"

namespace handgraft::server {

namespace {

constexpr std::size_t kLongHistory = 256;  // entries that are played when it is opened

/// Rows of the models that it was opened with.
std::vector<std::int64_t> rowsOf(LiveSession& live, const ModelStore& models) {
  const session::Document& document = live.session().document();
  std::vector<std::int64_t> rows;
  const auto add = [&](v1::ModelKind kind, const std::string& name, const Origin& origin) {
    if (live.journal->names(kind, name) && origin.row != 0) rows.push_back(origin.row);
  };
  add(v1::MODEL_HAND, document.hand, models.hand(document.hand)->origin);
  add(v1::MODEL_OBJECT, document.object, models.object(document.object)->origin);
  if (live.motion() != nullptr) {
    const std::string& name = live.motion()->name;
    add(v1::MODEL_MOTION, name, models.motion(name)->origin);
  } else {
    add(v1::MODEL_CONTACTS, document.contacts, models.contacts(document.contacts)->origin);
  }
  return rows;
}

/// Plays what came after the text: edits anew, solves by their answers.
void play(LiveSession& live,
          const std::vector<std::string>& entries,
          const Progress& progress) {
  session::Session& session = live.session();
  for (const std::string& text : entries) {
    progress.checkpoint();
    const session::LogEntry entry = io::readEntryText(text);
    if (const auto* edit = std::get_if<session::Edit>(&entry)) {
      const session::EditResult result = session.apply(*edit, progress);
      live.noteEdit({result.revision, session::describe(*edit, *session.hand().model), {}});
    } else if (const auto* solve =
                   std::get_if<std::shared_ptr<const session::CommittedSolve>>(&entry)) {
      session.commit(**solve);
    } else if (const auto* followed = std::get_if<session::FollowedMotion>(&entry)) {
      session.noteFollowed(*followed);
      resumeFollowing(live, *followed);
    } else {
      session.noteCancelledSolve();
    }
  }
}

}  // namespace

void keepSession(LiveSession& live,
                 HandlerContext& context,
                 const RequestKey& by,
                 const std::string& operation) {
  if (context.state == nullptr) return;
  live.journal = std::make_unique<SessionJournal>(*context.state, live.id(), 0, 0);
  KeptSession kept;
  kept.text = io::sessionText(live.session());
  if (live.motion() != nullptr) kept.motion = live.motion()->name;
  kept.models = rowsOf(live, context.models);
  kept.access = live.access();
  context.state->addSession(live.id(), kept, idl::jsonText(live.state()), by, operation);
}

std::shared_ptr<LiveSession> openKeptSession(std::uint64_t id,
                                             HandlerContext& context,
                                             const Progress& progress) {
  const KeptSession kept = context.state->session(id);
  const io::SessionFile file = io::readSessionText(kept.text);
  const auto models = context.persisted_models->named(kept.models);
  session::SessionModels made = kept.motion.empty()
                                    ? sessionModels(file.hand, file.object, file.contacts,
                                                    *models, sourceOf(models), progress)
                                    : motionModels(file.hand, file.object, kept.motion, *models,
                                                   sourceOf(models), progress);
  std::optional<LiveMotion> motion;
  if (!kept.motion.empty()) {
    motion = LiveMotion{kept.motion, models->motion(kept.motion)->motion, made.object_O};
  }
  auto live = std::make_shared<LiveSession>(
      id, io::openSession(file, std::move(made), progress), context.pool, context.audience);
  live->belongTo(context.sessions.serverId());
  live->grant(kept.access, PublishedState::kSilently);
  if (motion) live->hold(std::move(*motion));
  for (const session::LogEntry& entry : file.session.log)
    if (const auto* followed = std::get_if<session::FollowedMotion>(&entry))
      resumeFollowing(*live, *followed);
  play(*live, kept.entries, progress);
  live->journal = std::make_unique<SessionJournal>(
      *context.state, id, kept.next + kept.entries.size(), kept.entries.size());
  for (const std::int64_t row : kept.models) {
    const PersistedModel model = context.state->model(row);
    live->journal->names(static_cast<v1::ModelKind>(model.kind), model.name);
  }
  // Later than all that any server before this one told of it.
  constexpr unsigned kPerOpening = 32;
  live->numberFrom(context.state->openings() << kPerOpening);
  live->recallFrom(kept.used);
  return live;
}

void resumeKeptSession(LiveSession& live, HandlerContext& context) {
  if (!followsEdits(live) && !live.session().document().start_is_known &&
      !live.session().needsSolve())
    return;
  solveAfterOpening(live, context);
}

void keepState(LiveSession& live) {
  if (live.journal == nullptr) return;
  if (live.journal->entriesSinceText() < kLongHistory) {
    return live.journal->keepState(idl::jsonText(live.state()), live.session().revision());
  }
  try {
    keepText(live);
  } catch (const std::exception& error) {  // the next time, then
    log::warn("event=store_waits session={} what={}", live.id(),
              handgraft::quoted(error.what()));
  }
}

void keepText(LiveSession& live) {
  if (live.journal == nullptr) return;
  live.journal->keepText(io::sessionText(live.session()), idl::jsonText(live.state()),
                         live.session().revision());
}

void putToSleep(LiveSession& live, HandlerContext& context) {
  context.sessions.sleep(live.state());
  live.is_asleep = true;
  live.journal = nullptr;
  live.cycle().forgetUndiagnosed();
}

}  // namespace handgraft::server
