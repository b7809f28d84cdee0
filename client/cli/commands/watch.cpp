#include <chrono>
#include <cstdio>

#include <fmt/format.h>

#include "client/cli/commands/commands.h"
#include "client/link/session_id.h"
#include "client/link/session_stream.h"
#include "client/present/interactive_client.h"
#include "client/present/interruption.h"
#include "client/present/json_output.h"
#include "client/present/text_output.h"
#include "core/base/error.h"

namespace handgraft::client {

namespace {

// Lines are read by other programs while this one runs.
void printLine(const std::string& line) {
  fmt::print("{}\n", line);
  std::fflush(stdout);
}

/// Prints what a session publishes, until that is enough.
class StreamPrinter {
 public:
  /// `now`: the session as it is; `most`: solutions that count, 0: any number.
  StreamPrinter(const v1::SessionState& now, std::uint64_t most, bool as_json)
      : now_(now), most_(most), as_json_(as_json) {}

  void print(const v1::PoseSolution& solution) {
    // The grasp that stands for a motion says nothing of it; a demonstrator's frames do.
    const bool stands_for_motion = !now_.motion().empty() && solution.time_s().empty();
    if (hasEnough() || stands_for_motion) return;
    if (solution.is_diagnosed()) ++seen_;
    printLine(as_json_ ? json::solutionEvent(solution, now_.joint_names())
                       : text::solutionLine(solution));
  }

  void print(const v1::SessionState& state) {
    // Who comes late is told older states first.
    if (hasEnough() || state.revision() < now_.revision()) return;
    is_closed_ = is_closed_ || state.phase() == v1::PHASE_CLOSED;
    printLine(as_json_ ? json::stateEvent(state) : text::stateLine(state));
  }

  /// Frames of its motion; the last ones of an answer count as a solution.
  void print(const v1::MotionFrames& frames) {
    if (hasEnough() || !frames.is_last() || frames.revision() < told_) return;
    told_ = frames.revision() + 1;
    ++seen_;
    printLine(as_json_ ? json::motionEvent(frames) : text::motionLine(frames));
  }

  [[nodiscard]] bool hasEnough() const { return most_ != 0 && seen_ >= most_; }

  [[nodiscard]] bool isClosed() const { return is_closed_; }

 private:
  const v1::SessionState& now_;
  const std::uint64_t most_;
  const bool as_json_;
  std::uint64_t seen_ = 0;
  std::uint64_t told_ = 0;  // the first revision of which the motion was not told
  bool is_closed_ = false;
};

/// As its stream would tell a motion that was solved before; no last frames where none is.
v1::MotionFrames motionAsItStands(Client& server, std::uint64_t session_id) {
  v1::MotionFramesRequest request;
  request.session_id(session_id);
  request.count(1);
  try {
    v1::MotionFrames frames = server.motionFrames(request).get();
    frames.is_last(true);
    return frames;
  } catch (const Refused&) {
    return {};
  }
}

}  // namespace

int run(const WatchOptions& options, const CommonOptions& common, Interruption& interruption) {
  Client server(interactiveClient(common.network, Absence::kFail, interruption));
  const std::uint64_t session_id = sessionMeant(server, options.session_id);
  const v1::SessionState now =
      server.describeSession(session_id).get();  // it is known to exist
  SessionStream stream(server, session_id);

  StreamPrinter printer(now, options.count, common.json);
  if (!now.motion().empty()) printer.print(motionAsItStands(server, session_id));
  while (!printer.isClosed() && !printer.hasEnough() && !interruption.requested()) {
    stream.take(
        [&](const v1::PoseSolution& solution) {
          printer.print(solution);
        },
        [&](const v1::SessionState& state) {
          printer.print(state);
        });
    for (const v1::MotionFrames& frames : stream.takeMotion())
      printer.print(frames);
    if (printer.hasEnough()) break;
    if (!server.alive()) {
      throw NoServer(fmt::format("handgraft-server on {} stopped answering",
                                 handgraft::describe(common.network)));
    }
    if (!printer.isClosed()) stream.wait(std::chrono::milliseconds(20));
  }
  return 0;
}

}  // namespace handgraft::client
