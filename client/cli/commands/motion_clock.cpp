// The clock that all who watch a session's motion share.
#include <fmt/format.h>

#include "client/cli/commands/commands.h"
#include "client/link/client.h"
#include "client/link/session_id.h"
#include "client/present/interactive_client.h"
#include "client/present/interruption.h"
#include "client/present/json_output.h"

namespace handgraft::client {

int run(const MotionClockOptions& options,
        const CommonOptions& common,
        Interruption& interruption) {
  Client server(interactiveClient(common.network, Absence::kFail, interruption));
  v1::ClockRequest request;
  request.session_id(sessionMeant(server, options.session_id));
  request.action(options.action);
  request.value(options.value);
  const v1::MotionClock clock = server.setClock(request).get();
  if (common.json) {
    fmt::print("{}\n", json::written({{"session_id", clock.session_id()},
                                      {"playing", clock.playing()},
                                      {"looping", clock.looping()},
                                      {"speed", clock.speed()},
                                      {"time_s", clock.time_s()},
                                      {"duration_s", clock.duration_s()},
                                      {"stamp_ns", clock.stamp_ns()}},
                                     2));
  } else {
    fmt::print("{} at {:.2f} of {:.2f} s, speed {:g}{}\n",
               clock.playing() ? "playing" : "paused", clock.time_s(), clock.duration_s(),
               clock.speed(), clock.looping() ? ", looping" : "");
  }
  return 0;
}

}  // namespace handgraft::client
