#include <algorithm>

#include <fmt/format.h>

#include "client/cli/commands/commands.h"
#include "client/link/client.h"
#include "client/link/session_id.h"
#include "client/present/interactive_client.h"
#include "client/present/json_output.h"
#include "client/present/text_output.h"
#include "core/base/error.h"

namespace handgraft::client {

namespace {

constexpr const char* kEveryone = "everyone";
constexpr const char* kNobody = "nobody";

v1::ShareRequest requestOf(const ShareOptions& options) {
  v1::ShareRequest request;
  request.owner(options.owner);
  for (const char* word : {kEveryone, kNobody}) {
    if (std::find(options.with.begin(), options.with.end(), word) == options.with.end())
      continue;
    if (options.with.size() > 1) rejectInput("{} stands alone, without names", word);
    request.access(word == kEveryone ? v1::ACCESS_ALL : v1::ACCESS_OWNER);
    return request;
  }
  request.access(v1::ACCESS_LISTED);
  request.identities(options.with);
  return request;
}

}  // namespace

int run(const ShareOptions& options, const CommonOptions& common, Interruption& interruption) {
  v1::ShareRequest request = requestOf(options);
  Client server(interactiveClient(common.network, Absence::kFail, interruption));
  request.session_id(sessionMeant(server, options.session_id));
  const v1::SessionState state = server.shareSession(request).get();
  if (common.json) {
    fmt::print("{}\n", json::written({{"session_id", state.session_id()},
                                      {"owner", state.owner()},
                                      {"shared_with", options.with}},
                                     2));
    return 0;
  }
  std::string with;
  for (const std::string& name : options.with)
    with += (with.empty() ? "" : ", ") + name;
  fmt::print("session {} is {}'s, and shared with {}\n", state.session_id(),
             text::plain(state.owner()), with);
  return 0;
}

}  // namespace handgraft::client
