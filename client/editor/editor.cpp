#include "client/editor/editor.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "client/editor/edit_builders.h"
#include "client/editor/match_values.h"
#include "client/editor/show_solution.h"
#include "client/link/hand_point.h"
#include "client/link/hand_side_edits.h"
#include "client/link/session_id.h"
#include "client/link/wire_pose.h"
#include "client/present/failure.h"
#include "client/present/joint_unit.h"
#include "client/present/json_output.h"
#include "client/present/progress_line.h"
#include "client/present/send_model.h"
#include "client/present/text_output.h"
#include "client/present/transfer_text.h"
#include "core/base/error.h"
#include "core/base/progress.h"

namespace handgraft::client::editor {

namespace fs = std::filesystem;

namespace {

constexpr int kMostNested = 8;  // scripts in scripts: more is a script that runs itself

std::string written(const Words& words) {
  std::string line;
  for (const std::string& word : words)
    line += (line.empty() ? "" : " ") + asWord(word);
  return line;
}

// Snapshots change nothing that a pose would follow.
bool isAnswered(const v1::EditBody& body) {
  return body._d() != v1::EDIT_SNAPSHOT;
}

// Asks no server.
bool isLocal(Action action) {
  return action == Action::kQuit || action == Action::kHelp || action == Action::kScript;
}

// Needs no session to stand, and none of its names.
bool standsAlone(Action action) {
  return action == Action::kLoad || action == Action::kJoin || action == Action::kSessions ||
         action == Action::kReplay;
}

// What `undo` and `redo` are about to take, in the order in which they take it.
std::vector<std::string> stepsOf(const v1::EditBody& body,
                                 const v1::SessionSettings& settings) {
  const bool back = body._d() == v1::EDIT_UNDO;
  const std::vector<std::string>& steps = back ? settings.undo() : settings.redo();
  const std::size_t count = std::min<std::size_t>(body.steps().count(), steps.size());
  return {steps.begin(), steps.begin() + static_cast<std::ptrdiff_t>(count)};
}

// A better pose on the way, where somebody looks.
EditedSession::OnSample shownBy(ProgressLine& progress, const EditedSession& session) {
  return [&](const v1::PoseSolution& solution) {
    if (solution.is_final()) return;
    progress.show(fmt::format("objective {:.6g}", solution.terms().objective()),
                  session.state().progress());
  };
}

const Value* optionOf(const Match& match, const char* name) {
  const auto found = match.options.find(name);
  return found == match.options.end() ? nullptr : &found->second;
}

}  // namespace

Editor::Editor(Client& server,
               Interruption& interruption,
               const Sink& sink,
               const v1::SessionState& state)
    : server_(server), interruption_(interruption), sink_(sink) {
  goOnIn(state);
}

void Editor::goOnIn(const v1::SessionState& state) {
  if (session_ && session_->id() != state.session_id()) before_ = session_->id();
  session_ = std::make_unique<EditedSession>(server_, state);
}

// === Lines

void Editor::run(const std::string& line) {
  for (const Words& words : commandsOf(line)) {
    runCommand(words);
    if (finished_) return;
  }
}

void Editor::runCommand(const Words& words) {
  const std::string command = written(words);
  if (depth_ > 0) sink_.echo(command);
  try {
    sink_.done(command, execute(read(words)));
  } catch (const std::exception& error) {
    if (sink_.isJson()) sink_.failed(command, failureOf(error));
    throw;
  }
}

Parsed Editor::read(const Words& words) {
  std::optional<Parsed> alone;
  try {
    alone = parse(words, {});
  } catch (const InvalidInput&) {
    // It may hold names that the server knows; if not, the complaint comes from below.
  }
  if (alone && isLocal(alone->command->action)) return *alone;
  reachServer();
  if (alone && standsAlone(alone->command->action)) return *alone;
  session_->requireStanding();
  return parse(words, session_->names());
}

void Editor::reachServer() {
  if (server_.alive() || !server_.rejoin()) return;
  if (session_->hasEnded()) return;
  const std::uint64_t shown = session_->shownRevision();
  goOnIn(server_.describeSession(session_->id()).get());
  session_->lookFrom(shown);
}

void Editor::runScript(const NextLine& next_line, const std::string& name) {
  struct Nested {
    explicit Nested(int& of) : depth(++of) {}

    ~Nested() { --depth; }

    Nested(const Nested&) = delete;
    Nested& operator=(const Nested&) = delete;
    int& depth;
  };

  const Nested nested(depth_);
  if (depth_ > kMostNested) rejectInput("{}: scripts nest at most {} deep", name, kMostNested);
  std::size_t number = 0;
  while (!finished_) {
    const std::optional<std::string> line = next_line();
    if (!line) return;
    ++number;
    try {
      run(*line);
      interruption_.checkpoint();
    } catch (const std::exception& error) {
      const Failure failure = failureOf(error);
      throw CommandFailed(
          {failure.exit_code, fmt::format("{}:{}: {}", name, number, failure.message)});
    }
  }
}

CommandOutput Editor::execute(const Parsed& command) {
  const Match& match = command.match;
  const auto file = [&](std::size_t index) {
    return fs::path(match.values.at(index).text);
  };
  switch (command.command->action) {
    case Action::kEdit:
      return edit(command);
    case Action::kSolve: {
      if (hasMotion()) return solveMotion(match);
      const bool as_kept = match.options.empty();
      return solve(as_kept ? std::nullopt
                           : std::optional(solvingWith(session_->settings().solving(), match)));
    }
    case Action::kShow:
      return show(match);
    case Action::kCompare:
      return compare(match);
    case Action::kSave:
      return save(file(0));
    case Action::kLoad:
      return load(file(0));
    case Action::kReplay:
      return replay(file(0));
    case Action::kExport:
      return exportTo(match.values.at(0).text, file(1));
    case Action::kPicture:
      return drawTo(file(0));
    case Action::kSuggest:
      return suggest(match);
    case Action::kWatch:
      return watch(match);
    case Action::kTime:
      return editAt(command.match);
    case Action::kSessions:
      return sessions();
    case Action::kJoin:
      return join(match);
    case Action::kHelp:
      return help(match);
    case Action::kScript:
      return script(match.values.at(0).text);
    case Action::kQuit:
      finished_ = true;
      return {};
    case Action::kClose:
      return close();
  }
  return {};
}

// === Edits and solves

CommandOutput Editor::edit(const Parsed& command) {
  Match match = command.match;
  const std::string_view pattern = command.command->pattern;
  const std::string_view verb = pattern.substr(0, pattern.find(' '));
  // Models may be files, as everywhere on the command line.
  if (verb == "hand" || verb == "object") {
    const std::string named = match.values.at(0).text;
    std::optional<ModelFiles> files;
    if (isPath(named)) {
      files = verb == "hand" ? handFiles(named, {}) : objectFiles(named);
    }
    ModelSender sender(server_, interruption_, false);
    try {
      match.values[0].text = nameOnServer(sender, named, files);
    } catch (const Refused& refused) {
      if (refused.code() != v1::ERROR_UNITS) throw;
      // Edits have no options; loaded, the model is known by its name.
      rejectInput("{} to handgraft load {} {}", refused.what(), verb, quoted(named));
    }
  }
  const v1::EditBody body = command.command->make(match, *session_);
  const bool steps = body._d() == v1::EDIT_UNDO || body._d() == v1::EDIT_REDO;
  std::vector<std::string> taken;
  if (steps) taken = stepsOf(body, session_->settings());
  CommandOutput output = publish(body);
  if (verb == "joint") output.text += movedAgain(match);
  if (body._d() == v1::EDIT_DRAG) output.text += endedAt(body.drag());
  if (steps) {
    const char* done = body._d() == v1::EDIT_UNDO ? "undone" : "redone";
    // A single one is in the server's message already.
    if (taken.size() > 1) {
      output.text +=
          fmt::format("{}: {}\n", done, text::plain(fmt::format("{}", fmt::join(taken, "; "))));
    }
    output.data[done] = taken;
  }
  return output;
}

std::string Editor::endedAt(const v1::DragEdit& drag) {
  if (hasMotion()) {
    return session_->when() ? ""
                            : "held beside the object, where that is as the motion begins; "
                              "after `at TIME` it is held in the world at that time\n";
  }
  constexpr double kNoticed = 0.002;  // m; what a person means by another place
  if (drag.weight() == 0.0) return "";
  const v1::PoseSolution* pose = session_->solution();
  if (pose == nullptr) return "";
  const std::size_t link = linkIndex(session_->hand(), drag.link());
  if (link >= pose->X_WL().size()) return "";
  const Eigen::Vector3d p_W = poseOf(pose->X_WL()[link]) * vectorOf(drag.p_L_m());
  const double off = (p_W - vectorOf(drag.target_W_m())).norm();
  if (off < kNoticed) return "";
  return fmt::format("held {:.0f} mm off its target, as near as limits and patches let it\n",
                     1e3 * off);
}

std::string Editor::movedAgain(const Match& bend) {
  constexpr double kNoticed = 0.005;  // m; rad or m: what a person means by another place
  const v1::PoseSolution* pose = session_->solution();
  if (pose == nullptr) return "";
  const std::vector<std::string>& joints = session_->state().joint_names();
  const auto joint = std::find(joints.begin(), joints.end(), bend.values.at(0).text);
  const auto index = static_cast<std::size_t>(joint - joints.begin());
  if (index >= pose->joint_positions().size()) return "";
  const double value = pose->joint_positions()[index];
  if (std::abs(value - bend.values.at(1).number) < kNoticed) return "";
  const JointUnit unit = unitOf(session_->hand().joints().at(index).kind());
  return fmt::format(
      "the search moved {} on to {:.4g} {}; lock it first, and it stays where it is put\n",
      bend.values.at(0).text, unit.scale * value, unit.name);
}

CommandOutput Editor::publish(const v1::EditBody& body) {
  const v1::EditReply reply = session_->edit(body);
  CommandOutput output;
  output.data = {{"revision", reply.revision()}, {"message", reply.message()}};
  if (!reply.message().empty()) output.text = text::plain(reply.message()) + "\n";
  if (!isAnswered(body)) {
    output.text += fmt::format("revision {}\n", reply.revision());
    return output;
  }
  if (hasMotion()) {
    // Once it was solved, its frames answer; before, the grasp that stands for it.
    const CommandOutput motion = tellMotion(reply.revision());
    output.text += motion.text;
    if (!motion.data.empty()) {
      output.data["motion"] = motion.data;
      return output;
    }
  }
  const v1::PoseSolution* solution = awaitPose(reply.revision());
  if (solution == nullptr) {
    output.text += fmt::format("revision {}: no new solution\n", reply.revision());
    return output;
  }
  const CommandOutput pose = tellPose(output.text);
  output.text = pose.text;
  output.data.update(pose.data);
  return output;
}

const v1::PoseSolution* Editor::awaitPose(std::uint64_t revision) {
  ProgressLine progress;
  try {
    return session_->awaitFinal(revision, shownBy(progress, *session_));
  } catch (const Cancelled&) {
    if (interruption_.terminated()) throw;
    progress.clear();
    session_->stopSolving();
  }
  // It may have been there just before.
  const v1::PoseSolution* solution = session_->solution();
  if (solution != nullptr && solution->revision() >= revision) return solution;
  throw CommandFailed({1, fmt::format("stopped: revision {} stands without a pose of its own; "
                                      "solve searches one, undo takes the edit back",
                                      revision)});
}

CommandOutput Editor::tellPose(const std::string& before) {
  constexpr EditedSession::Timeout kSoon(250);  // usual explanations take milliseconds
  const bool at_once = at_once_ && depth_ == 0 && !sink_.isJson();
  const v1::PoseSolution pose = *session_->solution();
  const bool shown = at_once && !pose.is_diagnosed();
  if (shown) sink_.begin(before + poseLine(pose, session_->patchesOff()));
  const v1::PoseSolution* last = nullptr;
  try {
    last =
        &session_->awaitDiagnosed(pose.revision(), at_once ? kSoon : EditedSession::kEndless);
  } catch (const Cancelled&) {
    session_->stopSolving();  // the pose stands
    last = session_->solution();
  } catch (...) {
    if (shown) sink_.begin("\n");
    throw;
  }
  const Off& off = session_->patchesOff();
  CommandOutput output;
  output.data = {{"solution", status(*last, off)}};
  if (!shown) {
    output.text = before + statusLine(*last, off) + "\n";
  } else if (last->revision() == pose.revision()) {
    const std::string explanation = text::explanation(*last);
    output.text = (explanation.empty() ? "" : "; " + explanation) + "\n";
    session_->diagnoseLater();
  } else {
    output.text = "\n";
  }
  return output;
}

CommandOutput Editor::solve(const std::optional<v1::SolveOptions>& options) {
  const std::uint64_t revision = session_->solve(options).revision();
  CommandOutput output = tellPose("");
  output.data["revision"] = revision;
  return output;
}

CommandOutput Editor::suggest(const Match& match) {
  constexpr double kLeastReach = 1e-4;  // m; idl/sessions.idl
  constexpr double kMostReach = 0.1;    // m
  v1::SuggestRequest request;
  request.session_id(session_->id());
  request.patch(match.values.at(0).text);
  if (const Value* reach = optionOf(match, "--reach")) {
    if (!(reach->number >= kLeastReach && reach->number <= kMostReach)) {
      rejectInput("--reach {}: it must be 0.1mm to 100mm", reach->text);
    }
    request.reach_m(reach->number);
  }
  if (const Value* count = optionOf(match, "--count")) {
    if (count->count < 1 || count->count > 100)
      rejectInput("--count {}: it must be 1 to 100", count->text);
    request.count(static_cast<std::uint32_t>(count->count));
  }
  const v1::SuggestReply reply = server_.suggest(request).get();
  CommandOutput output;
  output.text = text::suggestions(reply);
  output.data = json::suggestions(reply, std::nullopt);
  const Value* apply = optionOf(match, "--apply");
  if (apply == nullptr) return output;
  if (apply->count < 1 || apply->count > reply.suggestions().size()) {
    rejectInput("--apply {}: there are {} suggestions", apply->text,
                reply.suggestions().size());
  }
  const v1::PlacementSuggestion& chosen = reply.suggestions()[apply->count - 1];
  CommandOutput last = publish(rootEdit(reply.patch(), chosen.root_S()));
  if (chosen.turned_rad() != 0.0)
    last = publish(directionEdit(reply.patch(), chosen.turned_rad()));
  output.text += last.text;
  output.data["applied"] = apply->count;
  output.data.update(last.data);
  return output;
}

// === Sessions

CommandOutput Editor::sessions() {
  const v1::SessionList list = server_.listSessions().get();
  return {text::sessions(list), json::jsonOf(list)};
}

CommandOutput Editor::join(const Match& match) {
  if (match.values.empty() && before_ == 0)
    rejectInput("join: there was no session before {}; `sessions` lists all", session_->id());
  const std::uint64_t session_id =
      match.values.empty() ? before_ : sessionMeant(server_, match.values[0].count);
  const std::uint64_t left = session_->id();
  const bool has_ended = session_->hasEnded();
  goOnIn(server_.describeSession(session_id).get());
  CommandOutput output;
  const std::string before = farewell(left, has_ended);
  if (!before.empty()) output.text = fmt::format("session {}{}\n", session_id, before);
  output.data = {{"session_id", session_id}, {"revision", session_->state().revision()}};
  return output;
}

std::string Editor::farewell(std::uint64_t left, bool has_ended) const {
  if (has_ended) return fmt::format("; the session {} before has ended with its server", left);
  return left == session_->id() ? "" : fmt::format("; session {} stays open", left);
}

CommandOutput Editor::close() {
  server_.closeSession(session_->id()).get();
  finished_ = true;
  closed_ = true;
  return {fmt::format("closed session {}\n", session_->id()),
          {{"session_id", session_->id()}, {"closed", true}}};
}

}  // namespace handgraft::client::editor
