#include "server/handlers/transfer.h"

#include <chrono>

#include "server/convert.h"

namespace handgraft::server {

v1::TransferReply transferPatches(LiveSession& live, const Progress& progress) {
  const v1::SessionPhase after = live.was_solved ? v1::PHASE_READY : v1::PHASE_OPEN;
  return runPhase(live, v1::PHASE_TRANSFERRING, after, progress, [&](const Progress& told) {
    const auto begin = std::chrono::steady_clock::now();
    live.session().transferPatches(told);
    const std::chrono::duration<double, std::milli> spent =
        std::chrono::steady_clock::now() - begin;
    v1::TransferReply reply;
    reply.session_id(live.id());
    reply.revision(live.session().revision());
    reply.patches(patchReports(live.session()));
    reply.transfer_ms(spent.count());
    return reply;
  });
}

}  // namespace handgraft::server
