#include <fmt/format.h>
#include <fmt/ranges.h>

#include "client/cli/commands/commands.h"
#include "client/gateway/page_file.h"
#include "client/link/client.h"
#include "client/link/session_id.h"
#include "client/present/export_file.h"
#include "client/present/interactive_client.h"
#include "client/present/json_output.h"
#include "client/present/output_file.h"
#include "client/present/text_output.h"
#include "core/base/error.h"

namespace handgraft::client {

namespace {

constexpr const char* kHtml = "html";  // the one format that the client makes

}  // namespace

int run(const ExportOptions& options, const CommonOptions& common, Interruption& interruption) {
  requireWritable({"--out", options.out});
  gateway::WebFiles page;
  if (options.format == kHtml) page = gateway::readWebFiles(gateway::webFolder());
  Client server(interactiveClient(common.network, Absence::kFail, interruption));
  const std::uint64_t session_id = sessionMeant(server, options.session_id);
  if (options.is_of_motion && !options.is_live &&
      server.describeSession(session_id).get().motion().empty()) {
    rejectInput("session {} holds a grasp, no motion; handgraft export writes it: {}",
                session_id, fmt::join(exportFormats(), ", "));
  }
  std::vector<std::string> notes;
  if (options.format == kHtml) {
    writeFile(options.out, gateway::pageFile(server, session_id, page));
  } else {
    notes = exportSession(server, session_id, options.format, {"--out", options.out},
                          options.is_live ? Exported::kLive : Exported::kAsSolved);
    for (const std::string& note : beyondOwnLimits(server.settings(session_id).get()))
      notes.push_back(note);
  }
  if (common.json) {
    fmt::print("{}\n", json::written({{"session_id", session_id},
                                      {"format", options.format},
                                      {"file", options.out.string()},
                                      {"notes", notes}},
                                     2));
  } else {
    fmt::print("wrote {}\n{}", quoted(options.out.string()), text::notes(notes));
  }
  return 0;
}

}  // namespace handgraft::client
