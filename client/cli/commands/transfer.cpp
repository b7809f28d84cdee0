#include <fmt/format.h>

#include "client/cli/commands/commands.h"
#include "client/link/server_link.h"
#include "client/present/json_output.h"
#include "client/present/progress_line.h"
#include "client/present/transfer_text.h"

namespace handgraft::client {

int run(const TransferOptions& options,
        const CommonOptions& common,
        Interruption& interruption) {
  ServerLink server(common.network, Absence::kFail, interruption);
  ProgressLine progress;
  server.onProgress([&](const std::string& stage, double fraction) {
    progress.show(stage, fraction);
  });
  const v1::TransferReply reply = server.transfer(options.session_id);
  progress.clear();
  fmt::print("{}", common.json ? json::document(reply) + "\n" : text::transfer(reply));
  return 0;
}

}  // namespace handgraft::client
