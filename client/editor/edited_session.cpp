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

/// What moves through the history is of no time.
bool hasTime(const v1::EditBody& body) {
  switch (body._d()) {
    case v1::EDIT_UNDO:
    case v1::EDIT_REDO:
    case v1::EDIT_SNAPSHOT:
    case v1::EDIT_RESTORE:
    case v1::EDIT_TAKE_BACK:
      return false;
    default:
      return true;
  }
}

using std::chrono::milliseconds;

constexpr milliseconds kPatience(20);

bool maySwitchPatches(const v1::EditBody& body) {
  switch (body._d()) {
    case v1::EDIT_PATCH_ENABLED:
    case v1::EDIT_PATCH_WEIGHT:
    case v1::EDIT_UNDO:
    case v1::EDIT_REDO:
    case v1::EDIT_RESTORE:
    case v1::EDIT_TAKE_BACK:
      return true;
    default:
      return false;
  }
}

}  // namespace

EditedSession::EditedSession(Client& server, const v1::SessionState& state)
    : server_(server), session_(server, state), shown_(state.revision()) {}

// === What a command may look up

const v1::SessionSettings& EditedSession::settings() {
  take();
  const v1::PoseSolution* last = session_.solution();
  const std::uint64_t sequence = last != nullptr ? last->sequence_number() : 0;
  const bool fresh = settings_ &&
                     settings_->state().revision() >= std::max(state().revision(), shown_) &&
                     settings_sequence_ == sequence;
  if (!fresh) {
    settings_ = session_.settings().get();
    settings_sequence_ = sequence;
  }
  return *settings_;
}

const v1::HandDescription& EditedSession::hand() {
  if (!hand_ || hand_of_ != state().hand()) {
    hand_of_ = state().hand();
    hand_ = server_.describe(v1::MODEL_HAND, hand_of_, false).get().hand();
    hand_has_meshes_ = false;
  }
  return *hand_;
}

const v1::HandDescription& EditedSession::handWithMeshes() {
  if (!hand_ || hand_of_ != state().hand() || !hand_has_meshes_) {
    hand_of_ = state().hand();
    hand_ = server_.describe(v1::MODEL_HAND, hand_of_, true).get().hand();
    hand_has_meshes_ = true;
  }
  return *hand_;
}

const v1::ObjectDescription& EditedSession::object() {
  if (!object_ || object_of_ != state().object()) {
    object_of_ = state().object();
    object_ = server_.describe(v1::MODEL_OBJECT, object_of_, true).get().object();
  }
  return *object_;
}

const v1::PoseSolution* EditedSession::solution() {
  try {
    session_.joinedSolution();
  } catch (const Cancelled&) {  // ends the wait: what is there stands
  }
  learn();
  return session_.solution();
}

Names EditedSession::names() {
  Names names;
  for (const v1::JointInfo& joint : hand().joints())
    names.joints.push_back(joint.name());
  for (const v1::MimicInfo& mimic : hand().mimics())
    names.followers.emplace(mimic.joint(), mimic.source());
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
  const bool is_of_motion = !state().motion().empty();
  const std::string& from = is_of_motion ? state().motion() : state().contacts();
  if (patches_.empty() || patches_of_ != from) {
    patches_.clear();
    patches_of_ = from;
    const v1::ModelDescription model =
        server_.describe(is_of_motion ? v1::MODEL_MOTION : v1::MODEL_CONTACTS, from, false)
            .get();
    if (is_of_motion) {
      patches_ = model.motion().patches();
    } else {
      for (const v1::PatchInfo& patch : model.contacts().patches())
        patches_.push_back(patch.name());
    }
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
    const v1::ModelList list = server_.listModels().get();
    for (const v1::ModelSummary& model : list.models()) {
      if (model.kind() == v1::MODEL_HAND) all.hands.push_back(model.name());
      if (model.kind() == v1::MODEL_OBJECT) all.objects.push_back(model.name());
    }
  });
  attempt([&] {
    const v1::SessionList list = server_.listSessions().get();
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
    v1::EditReply reply =
        session_.edit(body, shown_, hasTime(body) ? when_ : std::nullopt).get();
    shown_ = reply.revision();
    if (maySwitchPatches(body)) off_is_known_ = false;
    return reply;
  } catch (const Refused& refused) {
    if (refused.code() != v1::ERROR_CONFLICT) throw;
    const v1::SessionState now = server_.describeSession(id()).get();
    const bool moved_on = now.revision() > shown_;  // else the name of something is taken
    session_.adopt(now);
    if (!moved_on) throw;
    shown_ = now.revision();
    throw Refused(
        refused.code(),
        fmt::format("{}; {}; nothing was changed: repeat the command if it still holds",
                    refused.what(), toldBy(now)));
  }
}

MotionUpdate EditedSession::awaitMotion(std::uint64_t revision) {
  constexpr std::chrono::milliseconds kOnTheWay(500);  // once the session rests
  std::optional<std::chrono::steady_clock::time_point> rests;
  MotionUpdate news;
  while (!news.is_complete) {
    server_.checkpoint();
    take();
    for (const v1::MotionFrames& some : session_.takeMotion()) {
      if (some.revision() < revision) continue;
      news.frame_count = some.frame_count();
      for (const v1::MotionFrame& frame : some.frames()) {
        news.first_s =
            news.changed == 0 ? frame.time_s() : std::min(news.first_s, frame.time_s());
        news.last_s = std::max(news.last_s, frame.time_s());
        news.max_depth_m = std::max(news.max_depth_m, frame.max_depth_m());
        news.self_depth_m = std::max(news.self_depth_m, frame.self_depth_m());
        ++news.changed;
      }
      news.is_complete = some.is_last();
    }
    if (news.is_complete) break;
    const v1::PoseSolution* pose = session_.solution();
    if (pose != nullptr && pose->revision() >= revision) break;
    const v1::SessionState& state = session_.state();
    const bool is_at_work = state.revision() < revision ||
                            state.phase() == v1::PHASE_OPTIMIZING ||
                            state.phase() == v1::PHASE_TRANSFERRING;
    const auto now = std::chrono::steady_clock::now();
    if (is_at_work || !rests) rests = now;
    if (now - *rests > kOnTheWay || session_.hasEnded()) break;
    session_.wait(std::chrono::milliseconds(20));
  }
  return news;
}

const v1::PoseSolution* EditedSession::awaitFinal(std::uint64_t revision,
                                                  const OnSample& on_sample) {
  try {
    const v1::PoseSolution* pose = session_.awaitFinal(revision, on_sample);
    learn();
    return pose;
  } catch (const SolveFailed& failed) {
    throw SolveFailed(text::plain(failed.what()));
  }
}

const v1::PoseSolution& EditedSession::awaitDiagnosed(std::uint64_t revision, Timeout longest) {
  const v1::PoseSolution& pose = session_.awaitDiagnosed(revision, longest);
  learn();
  return pose;
}

void EditedSession::diagnoseLater() {
  const v1::PoseSolution* last = session_.solution();
  if (last != nullptr && !last->is_diagnosed()) owed_diagnosis_ = last->revision();
}

const v1::PoseSolution& EditedSession::solve(const std::optional<v1::SolveOptions>& options) {
  const v1::PoseSolution& pose = session_.adopt(session_.solve(options).get());
  learn();
  return pose;
}

// === Following

void EditedSession::take(const OnSample& on_sample, const OnState& on_state) {
  session_.take(on_sample, on_state);
  learn();
}

void EditedSession::learn() {
  const v1::PoseSolution* last = session_.solution();
  if (last == nullptr || !last->is_diagnosed() || last->revision() < shown_) return;
  off_ = offIn(*last);
  off_is_known_ = true;
}

std::string EditedSession::toldBy(const v1::SessionState& state) const {
  return fmt::format("revision {}, by {}: {}", state.revision(),
                     nameOf(state.last_client(), server_.id()),
                     state.last_edit().empty() ? "an edit" : text::plain(state.last_edit()));
}

std::vector<std::string> EditedSession::news() {
  take();
  const v1::PoseSolution* last = session_.solution();
  std::vector<std::string> lines;
  if (const bool answers = server_.alive(); answers != server_answers_) {
    server_answers_ = answers;
    lines.emplace_back(answers ? "a server answers again" : "the server stopped answering");
  }
  if (hasEnded() && !end_was_told_) {
    end_was_told_ = true;
    lines.push_back(fmt::format("session {} has ended with its server", id()));
  }
  if (owed_diagnosis_ && last != nullptr && last->revision() > *owed_diagnosis_) {
    owed_diagnosis_.reset();  // an edit came first
  } else if (owed_diagnosis_ && last != nullptr && last->is_diagnosed()) {
    lines.push_back(fmt::format("revision {}: {}", *owed_diagnosis_, text::explanation(*last)));
    owed_diagnosis_.reset();
  }
  if (state().phase() == v1::PHASE_CLOSED && !end_was_told_) {
    end_was_told_ = true;
    lines.push_back(fmt::format("session {} has been closed", id()));
  } else if (state().revision() > shown_) {
    shown_ = state().revision();
    lines.push_back(toldBy(state()));
  }
  return lines;
}

void EditedSession::follow(const OnSample& on_sample, const OnState& on_state) {
  take(on_sample, [&](const v1::SessionState& state) {
    shown_ = std::max(shown_, state.revision());
    if (on_state) on_state(state);
  });
  if (state().phase() == v1::PHASE_CLOSED) return;
  session_.requireOpen();
  session_.wait(kPatience);
}

}  // namespace handgraft::client::editor
