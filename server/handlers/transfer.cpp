#include "server/handlers/transfer.h"

#include <algorithm>
#include <chrono>

#include "server/messages/transfer_messages.h"

namespace handgraft::server {

void bringUpToDate(LiveSession& live, const Progress& progress) {
  const auto& patches = live.session().patches();
  const bool is_stale =
      std::any_of(patches.begin(), patches.end(), [](const session::SessionPatch& patch) {
        return patch.placement && !patch.up_to_date;
      });
  if (!is_stale) return;
  const auto begin = std::chrono::steady_clock::now();
  live.session().transferPatches(progress);
  const std::chrono::duration<double, std::milli> spent =
      std::chrono::steady_clock::now() - begin;
  live.transfer_ms = spent.count();
  live.untold_transfer_ms += spent.count();
}

v1::TransferReply transferPatches(LiveSession& live, const Progress& progress) {
  const v1::SessionPhase after = live.was_solved ? v1::PHASE_READY : v1::PHASE_OPEN;
  v1::TransferReply reply;
  runPhase(live, v1::PHASE_TRANSFERRING, after, progress, [&](const Progress& told) {
    bringUpToDate(live, told);
    reply.session_id(live.id());
    reply.revision(live.session().revision());
    reply.patches(patchReports(live.session()));
    reply.notes(live.session().notes());
    reply.transfer_ms(live.transfer_ms);
    reply.options(toMessage(live.session().transferOptions()));
  });
  return reply;
}

}  // namespace handgraft::server
