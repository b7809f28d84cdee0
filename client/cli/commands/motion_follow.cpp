#include <chrono>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <fmt/format.h>

#include "client/cli/commands/commands.h"
#include "client/cli/commands/follow_answers.h"
#include "client/link/client.h"
#include "client/link/demonstration.h"
#include "client/link/following.h"
#include "client/link/session_id.h"
#include "client/present/export_file.h"
#include "client/present/failure.h"
#include "client/present/interactive_client.h"
#include "client/present/interruption.h"
#include "client/present/joint_unit.h"
#include "client/present/json_output.h"
#include "client/present/output_file.h"
#include "core/base/error.h"
#include "core/base/time_note.h"

namespace handgraft::client {

namespace {

using FollowClock = FollowAnswers::Clock;

constexpr std::chrono::milliseconds kLastAnswers(300);
constexpr int kFailed = 1;

}  // namespace

int run(const MotionFollowOptions& options,
        const CommonOptions& common,
        Interruption& interruption) {
  std::vector<NamedFile> written;
  for (const MotionFile& file : options.out)
    written.push_back({"--out", file.path});
  requireSafe(written, {{"demonstration", options.demonstration}});
  const Demonstration demonstration = readDemonstration(options.demonstration);
  const std::vector<v1::DemonstratorFrame>& frames = demonstration.frames;
  std::vector<double> times;
  for (const v1::DemonstratorFrame& frame : frames)
    times.push_back(frame.time_s());
  // Nobody waits an hour for the end of a recording of four seconds to read it.
  const auto tell = [&](const std::string& note) {
    if (note.empty()) return;
    fmt::print(stderr, "handgraft: {}: {}\n", quoted(options.demonstration.string()), note);
  };
  tell(timeUnitNote(times));
  for (const std::string& note : demonstration.notes)
    tell(note);
  Client server(interactiveClient(common.network, Absence::kFail, interruption));
  const std::uint64_t session_id = sessionMeant(server, options.session_id);
  const v1::SessionState before = server.describeSession(session_id).get();
  tell(noteOfAnotherObject(demonstration, before));
  tell(noteOfTheOtherSide(demonstration,
                          server.describe(v1::MODEL_HAND, before.hand(), false).get().hand()));
  FollowAnswers answers(before.following());
  Listener listener;
  listener.on_solution = [&answers](const v1::PoseSolution& solution) {
    answers.came(solution, FollowClock::now());
  };
  listener.on_state = [&answers](const v1::SessionState& session) {
    answers.said(session.following(), FollowClock::now());
  };
  const Following following(server, session_id, listener);
  DemonstratorWriter writer(server, session_id);

  const FollowClock::time_point begin = FollowClock::now();
  const double first_s = frames.front().time_s();
  const double interval_s =
      frames.size() > 1 ? (frames.back().time_s() - first_s) / double(frames.size() - 1) : 1.0;
  double lap_s = 0.0;
  do {
    for (const v1::DemonstratorFrame& frame : frames) {
      const double time_s = lap_s + (frame.time_s() - first_s) / options.speed;
      std::this_thread::sleep_until(begin + std::chrono::duration_cast<FollowClock::duration>(
                                                std::chrono::duration<double>(time_s)));
      if (interruption.requested() || answers.isHopeless(FollowClock::now())) break;
      v1::DemonstratorFrame message = frame;
      message.time_s(time_s);
      answers.sent(time_s, FollowClock::now());
      writer.write(message);
    }
    lap_s += (frames.back().time_s() - first_s + interval_s) / options.speed;
  } while (options.loops && !interruption.requested() &&
           !answers.isHopeless(FollowClock::now()));
  if (!answers.isHopeless(FollowClock::now())) std::this_thread::sleep_for(kLastAnswers);
  // A signal ends the frames, not what is told and written of them; a second one does.
  interruption.forget();

  const double p50 = answers.latency(0.5);
  const double p99 = answers.latency(0.99);
  const v1::SessionState state = server.describeSession(session_id).get();
  const std::optional<std::string> refusal = answers.refusal();
  const FollowAnswers::Refusals refusals = answers.refusals();
  const std::optional<std::string> waiting = answers.waiting();
  OutputFiles outputs;
  for (const MotionFile& file : options.out) {
    if (answers.count() == 0) break;
    outputs.write([&] {
      for (const std::string& note : exportSession(server, session_id, file.format,
                                                   {"--out", file.path}, Exported::kLive))
        fmt::print(stderr, "handgraft: {}: {}\n", quoted(file.path.string()), note);
      if (!common.json) fmt::print("wrote {}\n", quoted(file.path.string()));
    });
  }
  const v1::HandDescription hand =
      server.describe(v1::MODEL_HAND, state.hand(), false).get().hand();
  const FollowAnswers::Step step = answers.largestStep();
  const FollowAnswers::Step root = answers.largestRootStep();
  const std::string joint = step.size > 0.0 && step.joint < hand.joints().size()
                                ? hand.joints()[step.joint].name()
                                : "";
  if (common.json) {
    const auto or_null = [](double value) {
      return std::isfinite(value) ? json::Json(value) : json::Json();
    };
    fmt::print("{}\n", json::written({{"session_id", session_id},
                                      {"frames", writer.count()},
                                      {"answered", answers.count()},
                                      {"touching", answers.touching()},
                                      {"waited", waiting ? json::Json(*waiting) : json::Json()},
                                      {"refusals", refusals.count},
                                      {"latency_p50_ms", or_null(p50)},
                                      {"latency_p99_ms", or_null(p99)},
                                      {"largest_step", step.size},
                                      {"largest_step_joint", joint},
                                      {"largest_step_s", step.time_s},
                                      {"largest_speed", answers.largestSpeed()},
                                      {"largest_root_step_m", root.size},
                                      {"largest_root_step_s", root.time_s},
                                      {"message", refusal.value_or(state.message())}},
                                     2));
  } else if (answers.count() > 0) {
    fmt::print("{} frames, {} answered by a pose; p50 {:.1f} ms, p99 {:.1f} ms\n",
               writer.count(), answers.count(), p50, p99);
    if (!joint.empty()) {
      const JointUnit unit = unitOf(hand.joints()[step.joint].kind());
      const JointUnit of_any = unitOfLargest(hand);
      fmt::print(
          "largest step {:.3g} {} by {} at {:.2f} s; largest speed but for the first step "
          "{:.3g} {} a second\n",
          unit.scale * step.size, unit.name, joint, step.time_s,
          of_any.scale * answers.largestSpeed(), of_any.name);
    }
    if (root.size > 0.0)
      fmt::print("largest step of the root {:.2g} mm at {:.2f} s\n", 1e3 * root.size,
                 root.time_s);
    if (waiting) fmt::print("frames without a pose while it waited: {}\n", *waiting);
    if (answers.touching() == 0)
      fmt::print("in none of them does a part of the hand show a touch\n");
    if (refusals.count > 0)
      fmt::print("frames were refused {} time{}, first at {:.2f} s: {}\n", refusals.count,
                 refusals.count == 1 ? "" : "s", refusals.first_s, *refusal);
    else if (!state.message().empty())
      fmt::print("{}\n", state.message());
  }
  outputs.requireWritten();
  if (refusal && answers.count() == 0) {
    throw CommandFailed(
        {kFailed, fmt::format("session {} refused it after {} of {} frames: {}", session_id,
                              writer.count(), frames.size(), *refusal)});
  }
  if (answers.count() == 0) {
    throw CommandFailed(
        {kFailed,
         fmt::format("session {}: none of {} frames was answered by a pose: {}", session_id,
                     writer.count(),
                     state.phase() == v1::PHASE_OPTIMIZING
                         ? fmt::format("it is solving its motion, {:.0f} %, and frames "
                                       "wait for that",
                                       100.0 * state.progress())
                         : answers.whyNone())});
  }
  return 0;
}

}  // namespace handgraft::client
