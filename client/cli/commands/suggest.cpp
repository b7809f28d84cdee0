#include <fmt/format.h>

#include "client/cli/commands/commands.h"
#include "client/link/client.h"
#include "client/link/hand_side_edits.h"
#include "client/link/session_id.h"
#include "client/present/interactive_client.h"
#include "client/present/json_output.h"
#include "client/present/progress_line.h"
#include "client/present/transfer_text.h"
#include "core/base/error.h"

namespace handgraft::client {

namespace {

// The two edits that make a suggestion come true (idl/sessions.idl), each refused if somebody
// else's came first.
std::uint64_t apply(Client& server,
                    const v1::SuggestReply& reply,
                    const v1::PlacementSuggestion& chosen) {
  const std::uint64_t id = reply.session_id();
  const v1::EditReply moved =
      server.edit(id, reply.revision(), rootEdit(reply.patch(), chosen.root_S())).get();
  if (chosen.turned_rad() == 0.0) return moved.revision();
  // Not `moved.revision()`: on revision 0 the first edit is taken whatever came before it.
  return server
      .edit(id, reply.revision() + 1, directionEdit(reply.patch(), chosen.turned_rad()))
      .get()
      .revision();
}

v1::PatchReport reportNow(Client& server, const v1::SuggestReply& reply) {
  const v1::TransferReply transfer = server.transfer(reply.session_id()).get();
  for (const v1::PatchReport& report : transfer.patches()) {
    if (report.name() == reply.patch()) return report;
  }
  throw TransportError(fmt::format("the server has no report of patch '{}'", reply.patch()));
}

}  // namespace

int run(const SuggestOptions& options,
        const CommonOptions& common,
        Interruption& interruption) {
  ProgressLine progress;
  Client server(interactiveClient(common.network, Absence::kFail, interruption, &progress));
  const std::uint64_t session_id = sessionMeant(server, options.session_id);
  v1::SuggestRequest request;
  request.session_id(session_id);
  request.patch(options.patch);
  request.reach_m(1e-3 * options.reach_mm);
  request.count(options.count);
  const v1::SuggestReply reply = server.suggest(request).get();

  std::optional<json::Applied> applied;
  if (options.apply > reply.suggestions().size()) {
    rejectInput("--apply {}: there are {} suggestions", options.apply,
                reply.suggestions().size());
  }
  if (options.apply > 0) {
    applied.emplace();
    applied->number = options.apply;
    applied->revision = apply(server, reply, reply.suggestions()[options.apply - 1]);
    applied->report = reportNow(server, reply);
  }

  progress.clear();
  if (common.json) {
    fmt::print("{}\n", json::written(json::suggestions(reply, applied)));
    return 0;
  }
  fmt::print("{}", text::suggestions(reply));
  if (applied) {
    fmt::print("\n{}", text::applied(applied->number, reply.suggestions()[applied->number - 1],
                                     applied->report, applied->revision));
  }
  return 0;
}

}  // namespace handgraft::client
