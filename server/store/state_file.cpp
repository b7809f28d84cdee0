#include "server/store/state_file.h"

#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "core/base/error.h"

namespace handgraft::server {

namespace fs = std::filesystem;

namespace {

/// Of the environment; empty: it says nothing.
std::string variable(const char* name) {
  // NOLINTNEXTLINE(concurrency-mt-unsafe): nobody writes the environment.
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

}  // namespace

StateFile stateFile(const std::string& folder, const Network& network) {
  if (folder == ":memory:") return {folder, ""};
  fs::path in = folder;
  if (in.empty()) {
    // systemd names several with colons between.
    const std::string systemd = variable("STATE_DIRECTORY");
    in = systemd.substr(0, systemd.find(':'));
  }
  const bool is_chosen = !in.empty();
  if (in.empty()) {
    if (const std::string xdg = variable("XDG_STATE_HOME"); !xdg.empty()) {
      in = fs::path(xdg) / "handgraft";
    } else if (const std::string home = variable("HOME"); !home.empty()) {
      in = fs::path(home) / ".local" / "state" / "handgraft";
    } else {
      return {":memory:", "neither $XDG_STATE_HOME nor $HOME says where it is kept"};
    }
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
