#include <fmt/format.h>

#include "client/cli/commands/commands.h"
#include "client/link/client.h"
#include "client/link/session_id.h"
#include "client/link/session_text.h"
#include "client/present/failure.h"
#include "client/present/interactive_client.h"
#include "client/present/json_output.h"
#include "client/present/output_file.h"
#include "client/present/text_output.h"
#include "core/base/error.h"

namespace handgraft::client {

namespace {

// One object with --json, else a line.
void tell(const CommonOptions& common, const json::Json& document, const std::string& line) {
  fmt::print("{}\n", common.json ? json::written(document, 2) : line);
}

}  // namespace

int run(const SaveOptions& options, const CommonOptions& common, Interruption& interruption) {
  requireWritable({"FILE", options.path});
  Client server(interactiveClient(common.network, Absence::kFail, interruption));
  const std::uint64_t session_id = sessionMeant(server, options.session_id);
  writeFile(options.path, server.saveSession(session_id).get());
  tell(common, {{"session_id", session_id}, {"file", options.path.string()}},
       fmt::format("wrote {}", quoted(options.path.string())));
  return 0;
}

int run(const OpenFileOptions& options,
        const CommonOptions& common,
        Interruption& interruption) {
  const std::string text = readSessionText(options.path);
  Client server(interactiveClient(common.network, Absence::kFail, interruption));
  const v1::SessionState state = askAbout(options.path, [&] {
    return server.loadSession(text).get();
  });
  tell(common, {{"session_id", state.session_id()}, {"revision", state.revision()}},
       fmt::format("session {}, revision {}: handgraft edit {}{}", state.session_id(),
                   state.revision(), state.session_id(), text::networkOptions(common.network)));
  return 0;
}

int run(const ReplayOptions& options, const CommonOptions& common, Interruption& interruption) {
  const std::string text = readSessionText(options.path);
  if (!options.out.empty()) {
    requireSafe({{"--out", options.out}}, {{"FILE", options.path}});
  }
  Client server(interactiveClient(common.network, Absence::kFail, interruption));
  const v1::ReplayReply reply = askAbout(options.path, [&] {
    return server.replay(text).get();
  });
  if (!options.out.empty()) writeFile(options.out, reply.result().text());
  const std::string ends = reply.same()
                               ? "it ends the same"
                               : "it ends differently: " + text::plain(reply.message());
  tell(common,
       {{"entries", reply.entries()}, {"same", reply.same()}, {"message", reply.message()}},
       fmt::format("{} entries played; {}", reply.entries(), ends));
  return reply.same() ? 0 : 1;
}

}  // namespace handgraft::client
