#include <fmt/format.h>

#include "client/cli/commands/commands.h"
#include "client/link/client.h"
#include "client/link/session_id.h"
#include "client/present/interactive_client.h"
#include "client/present/json_output.h"
#include "client/present/progress_line.h"
#include "client/present/transfer_text.h"

namespace handgraft::client {

int run(const TransferOptions& options,
        const CommonOptions& common,
        Interruption& interruption) {
  ProgressLine progress;
  Client server(interactiveClient(common.network, Absence::kFail, interruption, &progress));
  const std::uint64_t session_id = sessionMeant(server, options.session_id);
  const v1::TransferReply reply = server.transfer(session_id).get();
  progress.clear();
  fmt::print("{}", common.json ? json::document(reply) + "\n" : text::transfer(reply));
  return 0;
}

}  // namespace handgraft::client
