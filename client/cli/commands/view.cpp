#include <chrono>
#include <cstdio>
#include <thread>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include "client/cli/commands/commands.h"
#include "client/cli/commands/grasp_session.h"
#include "client/gateway/gateway.h"
#include "client/gateway/web_request.h"
#include "client/link/session_id.h"
#include "client/link/session_text.h"
#include "client/present/interactive_client.h"
#include "client/present/json_output.h"
#include "client/present/progress_line.h"
#include "core/base/environment.h"
#include "core/base/error.h"

namespace handgraft::client {

namespace {

using gateway::Gateway;

constexpr std::chrono::milliseconds kLook(50);

/// A screen that a browser could open a window on.
bool hasScreen() {
  return !environment("DISPLAY").empty() || !environment("WAYLAND_DISPLAY").empty();
}

/// Has the desktop open it, and waits for neither it nor the browser.
void openBrowser(const std::string& address) {
  const pid_t child = fork();
  if (child == 0) {
    if (fork() == 0) {
      const int nowhere = open("/dev/null", O_RDWR | O_CLOEXEC);
      for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
        dup2(nowhere, stream);
      execlp("xdg-open", "xdg-open", address.c_str(), static_cast<char*>(nullptr));
    }
    _exit(0);
  }
  if (child > 0) waitpid(child, nullptr, 0);
}

/// The session to show; 0: the page lists those there are.
std::uint64_t openAsked(const ViewOptions& options,
                        GraspInputs& inputs,
                        const std::string& saved,
                        Client& server,
                        Interruption& interruption) {
  if (options.session_id != 0) return sessionMeant(server, options.session_id);
  v1::OptimizeRequest solve;
  if (!options.file.empty()) {
    solve.session_id(askAbout(options.file, [&] {
                       return server.loadSession(saved).get();
                     }).session_id());
  } else if (!options.grasp.hand.empty()) {
    v1::OpenSessionRequest request = sessionRequest(options.grasp);
    ModelSender sender(server, interruption, true);
    solve.session_id(openSession(server, sender, options.grasp, inputs, request).session_id());
    solve.options().push_back(solvingOf(options.grasp));
  } else {
    return 0;
  }
  server.optimize(solve).get();
  return solve.session_id();
}

}  // namespace

int run(const ViewOptions& options, const CommonOptions& common, Interruption& interruption) {
  // === Everything that can be wrong before a server is asked
  gateway::WebFiles files = gateway::readWebFiles(gateway::webFolder());
  GraspInputs inputs;
  if (!options.grasp.hand.empty()) inputs = collectInputs(options.grasp);
  std::string saved;
  if (!options.file.empty()) saved = readSessionText(options.file);
  gateway::WebOptions web;
  web.address = options.address;
  web.port = options.port;
  web.read_only = options.read_only;
  // Others on this machine reach a loopback address, too: they must not act by an identity that
  // is not theirs.
  if (!gateway::isLoopback(options.address) || !common.network.identity.empty()) {
    web.edit_token = gateway::randomToken();
    web.look_token = gateway::randomToken();
  }

  // === The session
  ProgressLine progress;
  Client server(interactiveClient(
      common.network, options.session_id == 0 ? Absence::kStartShared : Absence::kFail,
      interruption, &progress));
  web.read_only = web.read_only || server.onlyLooks();
  const std::uint64_t session = openAsked(options, inputs, saved, server, interruption);
  if (session != 0) {
    // It is known to exist; what it takes to describe the hand is made before a page asks.
    const v1::SessionState state = server.describeSession(session).get();
    server.describe(v1::MODEL_HAND, state.hand(), true)
        .then([](const Outcome<v1::ModelDescription>&) {});
  }
  progress.clear();

  // === The page
  Gateway gateway(server, web, std::move(files));
  const std::string address = gateway::addressOf(web, gateway.port()) +
                              (session == 0 ? "" : fmt::format("?session={}", session));
  const std::string edit_link =
      address + (web.edit_token.empty() || web.read_only ? "" : "#token=" + web.edit_token);
  const std::string look_link =
      web.look_token.empty() ? "" : address + "#token=" + web.look_token;
  if (common.json) {
    fmt::print(
        "{}\n",
        json::written({{"address", web.read_only && !look_link.empty() ? look_link : edit_link},
                       {"look_address", look_link},
                       {"session_id", session}},
                      -1));
  } else {
    if (!web.read_only || look_link.empty()) fmt::print("{}\n", edit_link);
    if (!look_link.empty()) fmt::print("to look and not to edit: {}\n", look_link);
    fmt::print("Ctrl-C ends\n");
  }
  std::fflush(stdout);
  if (options.open_browser && hasScreen()) openBrowser(edit_link);
  while (!interruption.requested()) {
    gateway.tend();
    std::this_thread::sleep_for(kLook);
  }
  return 0;
}

}  // namespace handgraft::client
