#include <chrono>
#include <string>

#include <fmt/format.h>

#include "client/editor/editor.h"
#include "client/editor/show.h"
#include "client/editor/show_solution.h"
#include "client/present/json_output.h"
#include "client/present/text_output.h"
#include "client/present/transfer_text.h"
#include "core/base/error.h"

// The editor's commands that only look.
namespace handgraft::client::editor {

const v1::PoseSolution& Editor::requirePose() {
  const v1::PoseSolution* solution = session_->solution();
  if (solution == nullptr) rejectInput("there is no solution yet; solve makes one");
  return *solution;
}

const v1::PoseSolution& Editor::requireSolution() {
  return session_->awaitDiagnosed(requirePose().revision(), EditedSession::kEndless);
}

CommandOutput Editor::show(const Match& match) {
  // The grasp that stands for a motion says nothing of it.
  if (match.values.empty() && !session_->state().motion().empty()) return showMotion();
  if (match.values.empty()) {
    const v1::PoseSolution& solution = requireSolution();
    std::optional<v1::Weights> weights;
    if (const v1::SessionSettings& settings = session_->settings();
        settings.state().revision() == solution.revision())
      weights = settings.weights();
    CommandOutput output = tellSolution(solution, session_->patchesOff(), weights);
    const v1::SessionState& state = session_->state();
    if (state.phase() == v1::PHASE_FAILED && solution.revision() < state.revision()) {
      output.text +=
          fmt::format("revision {} was not solved: {}; the figures are of revision {}\n",
                      state.revision(), text::plain(state.message()), solution.revision());
      output.data["not_solved"] = {{"revision", state.revision()},
                                   {"message", state.message()}};
    }
    return output;
  }
  const std::string& topic = match.values[0].text;
  if (topic == "minima") return tellMinima(requirePose(), session_->hand());
  if (topic == "transfer") {
    const v1::TransferReply transfer = server_.transfer(session_->id()).get();
    return {text::transfer(transfer), json::jsonOf(transfer)};
  }
  const v1::SessionSettings& settings = session_->settings();
  if (topic == "patches") return tellPatches(settings);
  if (topic == "joints") return tellJoints(settings);
  if (topic == "settings") return tellSettings(settings);
  if (topic == "history") return tellHistory(settings);
  if (topic == "snapshots") return tellSnapshots(settings);
  if (topic == "times") return tellTimes(settings);
  return tellSession(settings, server_.id());
}

CommandOutput Editor::compare(const Match& match) {
  v1::CompareRequest request;
  request.session_id(session_->id());
  request.a(match.values.at(0).text);
  if (match.values.size() > 1) request.b(match.values[1].text);
  return tellDifferences(server_.compare(request).get(), request.a(), request.b(),
                         session_->hand());
}

CommandOutput Editor::watch(const Match& match) {
  using Clock = std::chrono::steady_clock;
  constexpr double kLongest = 1e6;  // s
  double seconds = kLongest;
  if (!match.values.empty()) {
    seconds = match.values[0].number;
    if (!(seconds >= 0.0 && seconds <= kLongest))
      rejectInput("watch {}: it must be 0 to 1e6 seconds", match.values[0].text);
  }
  const auto until = Clock::now() + std::chrono::duration<double>(seconds);
  const std::vector<std::string> joints = session_->state().joint_names();
  std::uint64_t count = 0;
  while (Clock::now() < until && !interruption_.requested() &&
         session_->state().phase() != v1::PHASE_CLOSED) {
    session_->follow(
        [&](const v1::PoseSolution& solution) {
          if (solution.is_diagnosed()) ++count;
          sink_.event(text::solutionLine(solution), json::solutionEvent(solution, joints));
        },
        [&](const v1::SessionState& state) {
          sink_.event(text::stateLine(state), json::stateEvent(state));
        });
  }
  CommandOutput output;
  output.data = {{"solutions", count}};
  return output;
}

CommandOutput Editor::help(const Match& match) {
  const Words begun = match.values.empty() ? Words() : Words{match.values[0].text};
  CommandOutput output;
  output.text = helpFor(begun, {});
  output.data = {{"help", output.text}};
  return output;
}

}  // namespace handgraft::client::editor
