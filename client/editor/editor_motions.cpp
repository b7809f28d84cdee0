#include <chrono>
#include <set>
#include <string>

#include <fmt/format.h>

#include "client/editor/edit_builders.h"
#include "client/editor/editor.h"
#include "client/present/json_output.h"
#include "client/present/motion_output.h"
#include "client/present/motion_result.h"
#include "core/base/error.h"
#include "core/base/progress.h"

// The editor in a session that holds a motion.
namespace handgraft::client::editor {

bool Editor::hasMotion() const {
  return !session_->state().motion().empty();
}

MotionResult Editor::motionAsItStands() {
  MotionResult result;
  result.session = session_->state();
  result.motion =
      server_.describe(v1::MODEL_MOTION, result.session.motion(), false).get().motion();
  result.hand = session_->hand();
  result.frames = framesOf(server_, session_->id());
  requireConsistent(result);
  return result;
}

CommandOutput Editor::showMotion() {
  MotionResult result = motionAsItStands();
  CommandOutput output{"", json::motionFit(result)};
  const std::optional<v1::EditTime>& when = session_->when();
  if (when) output.data["frame"] = json::motionFrame(result, when->time_s());
  const std::set<std::string> off = session_->patchesOff();
  for (std::string& patch : result.motion.patches())
    if (off.contains(patch)) patch += " (off)";
  output.text = text::motionFit(result);
  if (when) output.text += "\n" + text::motionFrame(result, when->time_s());
  return output;
}

CommandOutput Editor::solveMotion(const Match& match) {
  v1::SolveMotionRequest request;
  request.session_id(session_->id());
  for (const auto& [option, value] : match.options) {
    if (option != "--starts" && option != "--seed")
      rejectInput("{}: it is of grasps; a motion has --starts and --seed", option);
  }
  if (!match.options.empty()) {
    const v1::SolveOptions given = solvingWith(session_->settings().solving(), match);
    v1::MotionOptions options;
    options.solving().starts(given.starts());
    options.solving().seed(given.seed());
    request.options().push_back(options);
  }
  const auto begin = std::chrono::steady_clock::now();
  const v1::MotionSummary summary = server_.solveMotion(request).get();
  MotionResult result = motionAsItStands();
  result.summary = summary;
  result.total_ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin)
          .count();
  CommandOutput output{text::motion(result), json::motionFit(result)};
  output.data["summary"] = json::jsonOf(summary);
  return output;
}

CommandOutput Editor::tellMotion(std::uint64_t revision) {
  MotionUpdate news;
  try {
    news = session_->awaitMotion(revision);
  } catch (const Cancelled&) {
    if (interruption_.terminated()) throw;
    session_->stopSolving();
    throw CommandFailed({1, fmt::format("stopped: revision {} stands, its frames are those of "
                                        "before; undo takes the edit back",
                                        revision)});
  }
  CommandOutput output;
  if (!news.is_complete) return output;
  output.data = {{"frames_changed", news.changed}, {"frame_count", news.frame_count}};
  output.text = news.changed == 0
                    ? fmt::format("revision {}: no frame of the motion changed\n", revision)
                    : fmt::format(
                          "revision {}: {} of {} frames changed, {:.3f} to {:.3f} s, at most "
                          "{:.2f} mm inside and {:.2f} in itself\n",
                          revision, news.changed, news.frame_count, news.first_s, news.last_s,
                          1e3 * news.max_depth_m, 1e3 * news.self_depth_m);
  if (news.changed > 0) {
    output.data["first_s"] = news.first_s;
    output.data["last_s"] = news.last_s;
    output.data["max_depth_m"] = news.max_depth_m;
    output.data["self_depth_m"] = news.self_depth_m;
  }
  return output;
}

CommandOutput Editor::editAt(const Match& match) {
  std::optional<v1::EditTime> when;
  if (!match.values.empty()) {
    if (!hasMotion()) {
      rejectInput(
          "at {:.6g} s: session {} holds a grasp, no motion, and has no times; edits hold as "
          "they are",
          match.values[0].number, session_->id());
    }
    when.emplace();
    when->time_s(match.values[0].number);
    if (match.values.size() > 1) when->falloff_s(match.values[1].number);
    const double duration_s =
        server_.describe(v1::MODEL_MOTION, session_->state().motion(), false)
            .get()
            .motion()
            .duration_s();
    if (!(when->time_s() >= 0.0 && when->time_s() <= duration_s)) {
      rejectInput("at {:.6g} s: the motion lasts from 0 to {:.6g} s", when->time_s(),
                  duration_s);
    }
    if (!(when->falloff_s() >= 0.0))
      rejectInput("a falloff of {:.6g} s: it must be 0 s and more", when->falloff_s());
  }
  session_->editAt(when);
  CommandOutput output;
  if (!when) {
    output.text = "edits are of all of the motion\n";
    output.data = {{"at_s", nullptr}};
    return output;
  }
  output.text = fmt::format("edits are at {:.6g} s of the motion{}\n", when->time_s(),
                            when->falloff_s() > 0.0
                                ? fmt::format(", fading over {:.6g} s", when->falloff_s())
                                : ", of that frame alone");
  output.data = {{"at_s", when->time_s()}, {"falloff_s", when->falloff_s()}};
  return output;
}

}  // namespace handgraft::client::editor
