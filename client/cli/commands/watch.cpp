#include <chrono>
#include <cstdio>

#include <fmt/format.h>

#include "client/cli/commands/commands.h"
#include "client/link/interruption.h"
#include "client/link/server_link.h"
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
  ServerLink server(common.network, Absence::kFail, interruption);
  const v1::SessionState now =
      server.describeSession(options.session_id);  // it is known to exist
  idl::cyclone::Reader<v1::SessionState> states(server.participant(), idl::kSessionTopic);
  idl::cyclone::Reader<v1::PoseSolution> solutions(server.participant(), idl::kSolutionTopic);

  bool closed = false;
  std::uint64_t seen = 0;
  const auto enough = [&] {
    return options.count != 0 && seen >= options.count;
  };
  while (!closed && !enough() && !interruption.requested()) {
    // What there is already when the session closes is shown before its last state.
    solutions.take([&](const v1::PoseSolution& solution) {
      if (solution.session_id() != options.session_id || enough()) return;
      if (solution.is_diagnosed()) ++seen;
      printLine(common.json ? json::solutionEvent(solution, now.joint_names())
                            : text::solutionLine(solution));
    });
    if (enough()) break;
    states.take([&](const v1::SessionState& state) {
      // Who comes late is told older states first.
      if (state.session_id() != options.session_id || state.revision() < now.revision()) return;
      closed = closed || state.phase() == v1::PHASE_CLOSED;
      printLine(common.json ? json::stateEvent(state) : text::stateLine(state));
    });
    if (!server.alive()) {
      throw idl::cyclone::NoServer(fmt::format("handgraft-server on {} stopped answering",
                                               handgraft::describe(common.network)));
    }
    if (!closed) solutions.wait(std::chrono::milliseconds(20));
  }
  return 0;
}

}  // namespace handgraft::client
