#include "client/editor/editor.h"

#include <chrono>
#include <fstream>

#include <fmt/format.h>

#include "client/editor/edit_making.h"
#include "client/failure.h"
#include "client/grasp_session.h"
#include "client/hand_side_edits.h"
#include "client/json_output.h"
#include "client/output_file.h"
#include "client/progress_line.h"
#include "client/send_model.h"
#include "client/text_output.h"
#include "client/transfer_json.h"
#include "client/transfer_text.h"
#include "core/base/error.h"
#include "core/base/progress.h"

namespace handgraft::client::editor {

namespace fs = std::filesystem;

namespace {

constexpr int kMostNested = 8;  // scripts in scripts: more is a script that runs itself

json::Json parsed(const std::string& document) {
  return json::Json::parse(document, nullptr, false);
}

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

// A better pose on the way, where somebody looks.
EditedSession::OnSample shownBy(ProgressLine& progress) {
  return [&progress](const v1::PoseSolution& solution) {
    if (solution.is_final()) return;
    progress.show(fmt::format("objective {:.6g}", solution.terms().objective()), 0.0);
  };
}

const Value* optionOf(const Match& match, const char* name) {
  const auto found = match.options.find(name);
  return found == match.options.end() ? nullptr : &found->second;
}

}  // namespace

Editor::Editor(ServerLink& server,
               Interruption& interruption,
               const Sink& sink,
               const v1::SessionState& state)
    : server_(server), interruption_(interruption), sink_(sink) {
  goOnIn(state);
}

void Editor::goOnIn(const v1::SessionState& state) {
  session_ = std::make_unique<EditedSession>(server_, interruption_, state);
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
    sink_.done(command, execute(parse(words, session_->names())));
  } catch (const std::exception& error) {
    if (sink_.isJson()) sink_.failed(command, failureOf(error));
    throw;
  }
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

Told Editor::execute(const Parsed& command) {
  const Match& match = command.match;
  const auto file = [&](std::size_t index) {
    return fs::path(match.values.at(index).text);
  };
  switch (command.command->action) {
    case Action::kEdit:
      return edit(command);
    case Action::kSolve: {
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
    case Action::kSessions:
      return sessions();
    case Action::kJoin:
      return join(match.values.at(0).count);
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

Told Editor::edit(const Parsed& command) {
  Match match = command.match;
  // Models may be files, as everywhere on the command line.
  if (command.command->make == editor::hand || command.command->make == editor::object) {
    const std::string named = match.values.at(0).text;
    std::optional<ModelFiles> files;
    if (isPath(named)) {
      files = command.command->make == editor::hand ? handFiles(named, {}) : objectFiles(named);
    }
    ModelSender sender(server_, interruption_, false);
    match.values[0].text = nameOnServer(sender, named, files);
  }
  return publish(command.command->make(match, *session_));
}

Told Editor::publish(const v1::EditBody& body) {
  const v1::EditReply reply = session_->edit(body);
  Told told;
  told.data = {{"revision", reply.revision()}, {"message", reply.message()}};
  if (!reply.message().empty()) told.text = text::plain(reply.message()) + "\n";
  if (!isAnswered(body)) {
    told.text += fmt::format("revision {}\n", reply.revision());
    return told;
  }
  ProgressLine progress;
  const v1::PoseSolution* solution = nullptr;
  try {
    solution = session_->awaitFinal(reply.revision(), shownBy(progress));
  } catch (const Cancelled&) {
    throw CommandFailed({1, fmt::format("revision {} stands and the server goes on solving it; "
                                        "undo takes it back",
                                        reply.revision())});
  }
  progress.clear();
  if (solution == nullptr) {
    told.text += fmt::format("revision {}: no new solution\n", reply.revision());
    return told;
  }
  told.text += statusLine(*solution) + "\n";
  told.data["solution"] = status(*solution);
  return told;
}

Told Editor::solve(const std::optional<v1::SolveOptions>& options) {
  const v1::PoseSolution& solution = session_->solve(options);
  Told told;
  told.text = statusLine(solution) + "\n";
  told.data = {{"revision", solution.revision()}, {"solution", status(solution)}};
  return told;
}

Told Editor::suggest(const Match& match) {
  constexpr double kLeastReach_m = 1e-4;  // idl/sessions.idl
  constexpr double kMostReach_m = 0.1;
  v1::SuggestRequest request;
  request.session_id(session_->id());
  request.patch(match.values.at(0).text);
  if (const Value* reach = optionOf(match, "--reach")) {
    if (!(reach->number >= kLeastReach_m && reach->number <= kMostReach_m)) {
      rejectInput("--reach {}: it must be 0.1mm to 100mm", reach->text);
    }
    request.reach_m(reach->number);
  }
  if (const Value* count = optionOf(match, "--count")) {
    if (count->count < 1 || count->count > 100)
      rejectInput("--count {}: it must be 1 to 100", count->text);
    request.count(static_cast<std::uint32_t>(count->count));
  }
  const v1::SuggestReply reply = server_.suggest(request);
  Told told;
  told.text = text::suggestions(reply);
  told.data = parsed(json::suggestions(reply, std::nullopt, -1));
  const Value* apply = optionOf(match, "--apply");
  if (apply == nullptr) return told;
  if (apply->count < 1 || apply->count > reply.suggestions().size()) {
    rejectInput("--apply {}: there are {} suggestions", apply->text,
                reply.suggestions().size());
  }
  const v1::PlacementSuggestion& chosen = reply.suggestions()[apply->count - 1];
  Told last = publish(rootEdit(reply.patch(), chosen.root_S()));
  if (chosen.turned_rad() != 0.0)
    last = publish(directionEdit(reply.patch(), chosen.turned_rad()));
  told.text += last.text;
  told.data["applied"] = apply->count;
  told.data.update(last.data);
  return told;
}

// === Looking

const v1::PoseSolution& Editor::requireSolution() {
  const v1::PoseSolution* solution = session_->solution();
  if (solution == nullptr) rejectInput("there is no solution yet; solve makes one");
  return *solution;
}

Told Editor::show(const Match& match) {
  if (match.values.empty()) return tellSolution(requireSolution());
  const std::string& topic = match.values[0].text;
  if (topic == "minima") return tellMinima(requireSolution(), session_->hand());
  if (topic == "transfer") {
    const v1::TransferReply transfer = server_.transfer(session_->id());
    return {text::transfer(transfer), parsed(json::transfer(transfer, -1))};
  }
  const v1::SessionSettings& settings = session_->settings();
  if (topic == "patches") return tellPatches(settings);
  if (topic == "joints") return tellJoints(settings);
  if (topic == "settings") return tellSettings(settings);
  if (topic == "history") return tellHistory(settings);
  if (topic == "snapshots") return tellSnapshots(settings);
  return tellSession(settings);
}

Told Editor::compare(const Match& match) {
  v1::CompareRequest request;
  request.session_id(session_->id());
  request.a(match.values.at(0).text);
  if (match.values.size() > 1) request.b(match.values[1].text);
  return tellDifferences(server_.compare(request));
}

Told Editor::watch(const Match& match) {
  using Clock = std::chrono::steady_clock;
  constexpr double kLongest_s = 1e6;
  double seconds = kLongest_s;
  if (!match.values.empty()) {
    seconds = match.values[0].number;
    if (!(seconds >= 0.0 && seconds <= kLongest_s))
      rejectInput("watch {}: it must be 0 to 1e6 seconds", match.values[0].text);
  }
  const auto until = Clock::now() + std::chrono::duration<double>(seconds);
  const std::vector<std::string> joints = session_->state().joint_names();
  std::uint64_t count = 0;
  while (Clock::now() < until && !interruption_.requested() &&
         session_->state().phase() != v1::PHASE_CLOSED) {
    session_->follow(
        [&](const v1::PoseSolution& solution) {
          ++count;
          sink_.event(text::solutionLine(solution), json::solutionEvent(solution, joints));
        },
        [&](const v1::SessionState& state) {
          sink_.event(text::stateLine(state), json::stateEvent(state));
        });
  }
  Told told;
  told.data = {{"solutions", count}};
  return told;
}

Told Editor::help(const Match& match) {
  const Words begun = match.values.empty() ? Words() : Words{match.values[0].text};
  Told told;
  told.text = helpFor(begun, {});
  told.data = {{"help", told.text}};
  return told;
}

// === Files

Told Editor::save(const fs::path& path) {
  requireWritable({"save", path});
  writeFile(path, server_.saveSession(session_->id()));
  return {fmt::format("wrote {}\n", quoted(path.string())), {{"file", path.string()}}};
}

Told Editor::load(const fs::path& path) {
  const std::uint64_t left = session_->id();
  goOnIn(server_.loadSession(readFile(path)));
  return {fmt::format("session {}, revision {}; session {} stays open\n", session_->id(),
                      session_->state().revision(), left),
          {{"session_id", session_->id()}, {"revision", session_->state().revision()}}};
}

Told Editor::replay(const fs::path& path) {
  const v1::ReplayReply reply = server_.replay(readFile(path));
  if (!reply.same()) {
    throw CommandFailed(
        {1, fmt::format("{}: {} entries played, and it ends differently: {}",
                        quoted(path.string()), reply.entries(), text::plain(reply.message()))});
  }
  return {fmt::format("{} entries played; it ends the same\n", reply.entries()),
          {{"entries", reply.entries()}, {"same", true}}};
}

Told Editor::exportTo(const std::string& format, const fs::path& path) {
  exportSession(server_, session_->id(), format, path);
  return {fmt::format("wrote {}\n", quoted(path.string())),
          {{"format", format}, {"file", path.string()}}};
}

Told Editor::drawTo(const fs::path& path) {
  requireWritable({"png", path});
  GraspResult result;
  result.solution = requireSolution();
  result.session = session_->state();
  result.transfer = server_.transfer(session_->id());
  result.hand = session_->handWithMeshes();
  writePicture(server_, path, result);
  return {fmt::format("wrote {}\n", quoted(path.string())), {{"file", path.string()}}};
}

Told Editor::script(const std::string& path) {
  std::ifstream in(path);
  if (!in) rejectInput("{}: cannot be read", quoted(path));
  runScript(
      [&]() -> std::optional<std::string> {
        std::string line;
        if (!std::getline(in, line)) return std::nullopt;
        return line;
      },
      path);
  return {"", {{"file", path}}};
}

// === Sessions

Told Editor::sessions() {
  const v1::SessionList list = server_.listSessions();
  return {text::sessions(list), parsed(json::sessions(list, -1))};
}

Told Editor::join(std::uint64_t session_id) {
  const std::uint64_t left = session_->id();
  goOnIn(server_.describeSession(session_id));
  Told told;
  told.text = left == session_id
                  ? std::string()
                  : fmt::format("session {}; session {} stays open\n", session_id, left);
  told.data = {{"session_id", session_id}, {"revision", session_->state().revision()}};
  return told;
}

Told Editor::close() {
  server_.closeSession(session_->id());
  finished_ = true;
  closed_ = true;
  return {fmt::format("closed session {}\n", session_->id()),
          {{"session_id", session_->id()}, {"closed", true}}};
}

}  // namespace handgraft::client::editor
