#include "server/handlers/transfer.h"

#include <algorithm>
#include <chrono>
#include <string>
#include <utility>
#include <vector>

#include "server/messages/transfer_messages.h"

namespace handgraft::server {

void updateTransfers(LiveSession& live, const Progress& progress) {
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
  live.took.transfer_ms = spent.count();
  live.took.untold_transfer_ms += spent.count();
}

v1::TransferReply transferPatches(LiveSession& live, const Progress& progress) {
  live.enter(v1::PHASE_TRANSFERRING);
  const Progress told(progress, [&](std::string_view stage, double fraction) {
    live.advance(stage, fraction);
    progress.report(stage, fraction);
  });
  try {
    updateTransfers(live, told);
  } catch (const Cancelled&) {
    live.tellEnd(SolveEnd::kCancelled);
    throw;
  } catch (const std::exception& error) {
    live.enter(v1::PHASE_FAILED, error.what());
    throw;
  }
  live.settle(live.cycle().wasSolved() ? v1::PHASE_READY : v1::PHASE_OPEN);
  const auto& patches = live.session().patches();
  v1::TransferReply reply;
  reply.session_id(live.id());
  reply.revision(live.session().revision());
  reply.patches(patchReports(live.session()));
  reply.notes(live.session().notes());
  const auto add = [&](std::vector<std::string> notes) {
    for (std::string& note : notes)
      reply.notes().push_back(std::move(note));
  };
  add(sizeNotes(patches, live.session().object(), live.session().hand().skin->mesh()));
  add(distortionNotes(patches));
  reply.transfer_ms(live.took.transfer_ms);
  reply.options(toMessage(live.session().transferOptions()));
  return reply;
}

}  // namespace handgraft::server
