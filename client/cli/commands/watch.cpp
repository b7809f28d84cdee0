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

}  // namespace

int run(const WatchOptions& options, const CommonOptions& common, Interruption& interruption) {
  Client server(interactiveClient(common.network, Absence::kFail, interruption));
  const std::uint64_t session_id = sessionMeant(server, options.session_id);
  const v1::SessionState now =
      server.describeSession(session_id).get();  // it is known to exist
  SessionStream stream(server, session_id);

  bool closed = false;
  std::uint64_t seen = 0;
  const auto enough = [&] {
    return options.count != 0 && seen >= options.count;
  };
  while (!closed && !enough() && !interruption.requested()) {
    stream.take(
        [&](const v1::PoseSolution& solution) {
          if (enough()) return;
          if (solution.is_diagnosed()) ++seen;
          printLine(common.json ? json::solutionEvent(solution, now.joint_names())
                                : text::solutionLine(solution));
        },
        [&](const v1::SessionState& state) {
          // Who comes late is told older states first.
          if (enough() || state.revision() < now.revision()) return;
          closed = closed || state.phase() == v1::PHASE_CLOSED;
          printLine(common.json ? json::stateEvent(state) : text::stateLine(state));
        });
    if (enough()) break;
    if (!server.alive()) {
      throw NoServer(fmt::format("handgraft-server on {} stopped answering",
                                 handgraft::describe(common.network)));
    }
    if (!closed) stream.wait(std::chrono::milliseconds(20));
  }
  return 0;
}

}  // namespace handgraft::client
