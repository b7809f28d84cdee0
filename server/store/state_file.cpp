#include "server/store/state_file.h"

#include <filesystem>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "core/base/environment.h"
#include "core/base/error.h"

namespace handgraft::server {

namespace fs = std::filesystem;

StateFile stateFile(const std::string& folder, const Network& network) {
  if (folder == ":memory:") return {folder, ""};
  fs::path in = folder;
  if (in.empty()) {
    // systemd names several with colons between.
    const std::string systemd = environment("STATE_DIRECTORY");
    in = systemd.substr(0, systemd.find(':'));
  }
  const bool is_chosen = !in.empty();
  if (in.empty()) {
    const auto state = userFolder("XDG_STATE_HOME", ".local/state");
    if (!state) return {":memory:", "neither $XDG_STATE_HOME nor $HOME says where it is kept"};
    in = *state / "handgraft";
  }
  std::error_code error;
  const bool is_new = fs::create_directories(in, error);
  if (error) {
    std::string why =
        fmt::format("folder {} cannot be made ({})", quoted(in.string()), error.message());
    if (is_chosen) rejectInput("state: {}", why);
    return {":memory:", std::move(why)};
  }
  // What people grasp is nobody else's business on this machine.
  if (is_new) fs::permissions(in, fs::perms::owner_all, error);
  const std::string name = network.server.empty() ? "" : "-" + network.server;
  return {(in / fmt::format("domain-{}{}.db", network.domain, name)).string(), ""};
}

}  // namespace handgraft::server
