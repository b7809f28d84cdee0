#include "client/editor/edited_session.h"

#include <algorithm>
#include <chrono>

#include <fmt/format.h>

#include "client/editor/show.h"
#include "client/editor/show_solution.h"
#include "client/present/text_output.h"
#include "core/base/error.h"
#include "core/base/progress.h"

namespace handgraft::client::editor {

namespace {

using std::chrono::milliseconds;

constexpr milliseconds kPatience(20);
constexpr milliseconds kLateJoin(2000);
constexpr milliseconds kNothingFollows(2000);  // after the session has come to rest

bool maySwitchPatches(const v1::EditBody& body) {
  switch (body._d()) {
    case v1::EDIT_PATCH_ENABLED:
    case v1::EDIT_PATCH_WEIGHT:
    case v1::EDIT_UNDO:
    case v1::EDIT_REDO:
    case v1::EDIT_RESTORE:
      return true;
    default:
      return false;
  }
}

}  // namespace

EditedSession::EditedSession(ServerLink& server,
                             Interruption& interruption,
                             const v1::SessionState& state)
    : server_(server),
      interruption_(interruption),
      states_(server.participant(), idl::kSessionTopic),
      solutions_(server.participant(), idl::kSolutionTopic),
      state_(state),
      server_id_(server.status().server_id()),
      shown_(state.revision()) {}

// === What a command may look up

const v1::SessionSettings& EditedSession::settings() {
  take({}, {});
  const std::uint64_t sequence = solution_ ? solution_->sequence_number() : 0;
  const bool fresh = settings_ &&
                     settings_->state().revision() >= std::max(state_.revision(), shown_) &&
                     settings_sequence_ == sequence;
  if (!fresh) {
    settings_ = server_.settings(id());
    settings_sequence_ = sequence;
  }
  return *settings_;
}

const v1::HandDescription& EditedSession::hand() {
  if (!hand_) {
    hand_ = server_.describe(v1::MODEL_HAND, state_.hand(), false).hand();
    hand_has_meshes_ = false;
  }
  return *hand_;
}

const v1::HandDescription& EditedSession::handWithMeshes() {
  if (!hand_ || !hand_has_meshes_) {
    hand_ = server_.describe(v1::MODEL_HAND, state_.hand(), true).hand();
    hand_has_meshes_ = true;
  }
  return *hand_;
}

const v1::ObjectDescription& EditedSession::object() {
  if (!object_) object_ = server_.describe(v1::MODEL_OBJECT, state_.object(), true).object();
  return *object_;
}

const v1::PoseSolution* EditedSession::solution() {
  take({}, {});
  // Late readers are brought the last pose once they are found.
  while (!solution_ && state_.phase() != v1::PHASE_OPEN && state_.phase() != v1::PHASE_CLOSED &&
         !hasEnded() && std::chrono::steady_clock::now() - joined_ < kLateJoin &&
         !interruption_.requested()) {
    solutions_.wait(kPatience);
    take({}, {});
  }
  return solution_ ? &*solution_ : nullptr;
}

Names EditedSession::names() {
  Names names;
  for (const v1::JointInfo& joint : hand().joints())
    names.joints.push_back(joint.name());
  for (const v1::SiteInfo& site : hand().sites()) {
    names.sites.push_back(site.name());
    names.points.push_back(site.name());
    names.points.push_back(site.name() + "_tip");
  }
  for (const v1::LinkInfo& link : hand().links()) {
    const auto& known = names.points;
    if (std::find(known.begin(), known.end(), link.name()) == known.end())
      names.points.push_back(link.name());
  }
  if (patches_.empty()) {
    const v1::ModelDescription contacts =
        server_.describe(v1::MODEL_CONTACTS, state_.contacts(), false);
    for (const v1::PatchInfo& patch : contacts.contacts().patches())
      patches_.push_back(patch.name());
  }
  names.patches = patches_;
  return names;
}

Names EditedSession::allNames() {
  const auto attempt = [&](const auto& ask) {
    try {
      ask();
    } catch (const std::exception&) {
      // Completion offers what it knows; errors are for commands.
    }
  };
  Names all;
  attempt([&] {
    all = names();
  });
  attempt([&] {
    const v1::ModelList list = server_.listModels();
    for (const v1::ModelSummary& model : list.models()) {
      if (model.kind() == v1::MODEL_HAND) all.hands.push_back(model.name());
      if (model.kind() == v1::MODEL_OBJECT) all.objects.push_back(model.name());
    }
  });
  attempt([&] {
    const v1::SessionList list = server_.listSessions();
    for (const v1::SessionState& session : list.sessions())
      all.sessions.push_back(std::to_string(session.session_id()));
  });
  attempt([&] {
    all.snapshots = settings().snapshots();
  });
  return all;
}

const std::set<std::string>& EditedSession::patchesOff() {
  if (!off_is_known_) {
    off_.clear();
    for (const v1::PatchState& patch : settings().patches()) {
      if (!patch.enabled() || patch.weight() == 0.0) off_.insert(patch.name());
    }
    off_is_known_ = true;
  }
  return off_;
}

// === Changing

v1::EditReply EditedSession::edit(const v1::EditBody& body) {
  try {
    const v1::EditReply reply = server_.edit(id(), shown_, body);
    shown_ = reply.revision();
    if (maySwitchPatches(body)) off_is_known_ = false;
    return reply;
  } catch (const idl::cyclone::Refused& refused) {
    if (refused.code() != v1::ERROR_CONFLICT) throw;
    const v1::SessionState now = server_.describeSession(id());
    const bool moved_on = now.revision() > shown_;  // else the name of something is taken
    keepUp(now);
    if (!moved_on) throw;
    shown_ = now.revision();
    throw idl::cyclone::Refused(
        refused.code(),
        fmt::format("{}; {}; nothing was changed: repeat the command if it still holds",
                    refused.what(), toldBy(now)));
  }
}

const v1::PoseSolution* EditedSession::awaitFinal(std::uint64_t revision,
                                                  const OnSample& on_sample) {
  auto settled = std::chrono::steady_clock::now();
  while (true) {
    take(on_sample, {});
    if (solution_ && solution_->revision() >= revision) return &*solution_;
    requireOpen();
    const bool is_answered = state_.revision() >= revision;
    if (is_answered && state_.phase() == v1::PHASE_FAILED) {
      throw SolveFailed(text::plain(state_.message()));
    }
    const auto now = std::chrono::steady_clock::now();
    if (!restsAt(revision)) settled = now;
    if (now - settled > kNothingFollows) return nullptr;
    interruption_.checkpoint();
    solutions_.wait(kPatience);
  }
}

bool EditedSession::restsAt(std::uint64_t revision) const {
  return state_.revision() >= revision &&
         (state_.phase() == v1::PHASE_READY || state_.phase() == v1::PHASE_OPEN ||
          state_.phase() == v1::PHASE_FAILED);
}

const v1::PoseSolution& EditedSession::awaitExplained(std::uint64_t revision,
                                                      Patience longest) {
  const auto begin = std::chrono::steady_clock::now();
  auto settled = begin;
  while (true) {
    take({}, {});
    HANDGRAFT_REQUIRE(solution_.has_value());
    if (solution_->is_diagnosed() || solution_->revision() > revision) return *solution_;
    requireOpen();
    const auto now = std::chrono::steady_clock::now();
    if (!restsAt(revision)) settled = now;
    if (now - settled > kNothingFollows || now - begin >= longest) return *solution_;
    interruption_.checkpoint();
    solutions_.wait(std::min(kPatience, longest));
  }
}

void EditedSession::explainLater() {
  if (solution_ && !solution_->is_diagnosed()) owed_explanation_ = solution_->revision();
}

const v1::PoseSolution& EditedSession::solve(const std::optional<v1::SolveOptions>& options) {
  v1::OptimizeRequest request;
  request.session_id(id());
  if (options) request.options().push_back(*options);
  const v1::PoseSolution solution = server_.optimize(request);
  // The stream may have brought it, or a later one, already.
  if (!solution_ || solution_->sequence_number() <= solution.sequence_number()) {
    adopt(solution);
  }
  return *solution_;
}

// === Following

void EditedSession::take(const OnSample& on_sample, const OnState& on_state) {
  solutions_.take([&](const v1::PoseSolution& solution) {
    if (solution.session_id() != id() || hasEnded()) return;
    if (solution.is_final()) adopt(solution);
    if (on_sample) on_sample(solution);
  });
  states_.take([&](const v1::SessionState& state) {
    // Who comes late is told older states first.
    if (state.session_id() != id() || state.revision() < state_.revision() || hasEnded())
      return;
    keepUp(state);
    if (on_state) on_state(state);
  });
}

void EditedSession::adopt(const v1::PoseSolution& solution) {
  solution_ = solution;
  if (!solution.is_diagnosed() || solution.revision() < shown_) return;
  off_ = offIn(solution);
  off_is_known_ = true;
}

void EditedSession::keepUp(const v1::SessionState& state) {
  if (state.hand() != state_.hand()) hand_.reset();
  if (state.object() != state_.object()) object_.reset();
  if (state.contacts() != state_.contacts()) patches_.clear();
  state_ = state;
}

std::string EditedSession::toldBy(const v1::SessionState& state) const {
  return fmt::format("revision {}, by {}: {}", state.revision(),
                     nameOf(state.last_client(), server_.client()),
                     state.last_edit().empty() ? "an edit" : text::plain(state.last_edit()));
}

void EditedSession::requireStanding() const {
  if (state_.phase() == v1::PHASE_CLOSED) {
    throw idl::cyclone::Refused(v1::ERROR_NOT_FOUND,
                                fmt::format("session {} has been closed", id()));
  }
  if (hasEnded()) {
    throw idl::cyclone::Refused(
        v1::ERROR_NOT_FOUND,
        fmt::format("session {} has ended with its server; load opens a saved one", id()));
  }
}

void EditedSession::requireOpen() {
  requireStanding();
  if (!server_.alive()) {
    throw idl::cyclone::NoServer(
        fmt::format("handgraft-server on {} stopped answering",
                    handgraft::describe(server_.participant().network())));
  }
}

std::vector<std::string> EditedSession::news() {
  take({}, {});
  std::vector<std::string> lines;
  if (const bool answers = server_.alive(); answers != server_answers_) {
    server_answers_ = answers;
    lines.emplace_back(answers ? "a server answers again" : "the server stopped answering");
  }
  if (hasEnded() && !end_was_told_) {
    end_was_told_ = true;
    lines.push_back(fmt::format("session {} has ended with its server", id()));
  }
  if (owed_explanation_ && solution_ && solution_->revision() > *owed_explanation_) {
    owed_explanation_.reset();  // an edit came first
  } else if (owed_explanation_ && solution_ && solution_->is_diagnosed()) {
    lines.push_back(
        fmt::format("revision {}: {}", *owed_explanation_, text::explanation(*solution_)));
    owed_explanation_.reset();
  }
  if (state_.phase() == v1::PHASE_CLOSED && !end_was_told_) {
    end_was_told_ = true;
    lines.push_back(fmt::format("session {} has been closed", id()));
  } else if (state_.revision() > shown_) {
    shown_ = state_.revision();
    lines.push_back(toldBy(state_));
  }
  return lines;
}

void EditedSession::follow(const OnSample& on_sample, const OnState& on_state) {
  take(on_sample, [&](const v1::SessionState& state) {
    shown_ = std::max(shown_, state.revision());
    if (on_state) on_state(state);
  });
  if (state_.phase() == v1::PHASE_CLOSED) return;
  requireOpen();
  solutions_.wait(kPatience);
}

}  // namespace handgraft::client::editor
