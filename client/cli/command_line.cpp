#include "client/cli/command_line.h"

#include <algorithm>
#include <sstream>

#include <CLI/CLI.hpp>

#include "client/cli/commands/version.h"
#include "client/cli/options/command_options.h"
#include "core/base/error.h"

namespace handgraft::client {

namespace {

// CLI11 says what is wrong over several lines at times; users get one.
std::string oneLine(const std::string& text) {
  std::string line = text.substr(0, text.find_last_not_of(" \n") + 1);
  std::replace(line.begin(), line.end(), '\n', ' ');
  return line;
}

std::string commandsOf(const CLI::App& app) {
  std::string names;
  for (const CLI::App* command : app.get_subcommands({})) {
    names += (names.empty() ? "" : ", ") + command->get_name();
  }
  return names;
}

/// Of a word that no option takes: a name with a blank in it, whose first word one did take, is
/// what it mostly is.
void requireOneWordEach(const std::string& extra, int argc, const char* const* argv) {
  for (int i = 3; i < argc; ++i) {
    const std::string option = argv[i - 2];
    const std::string first = argv[i - 1];
    if (argv[i] != extra || option.rfind("--", 0) != 0 || first.rfind("--", 0) == 0) continue;
    rejectInput("{} takes one word, {}; {} is one too many, a name with blanks needs quotes",
                option, quoted(first), quoted(extra));
  }
}

}  // namespace

double longestOf(const CommandOptions& command) {
  constexpr double kLongest = 3600.0;
  const bool is_endless = std::holds_alternative<EditOptions>(command) ||
                          std::holds_alternative<WatchOptions>(command) ||
                          std::holds_alternative<ViewOptions>(command) ||
                          std::holds_alternative<MotionPlayOptions>(command) ||
                          std::holds_alternative<MotionFollowOptions>(command) ||
                          std::holds_alternative<SweepOptions>(command) ||
                          std::holds_alternative<BridgeRecordOptions>(command) ||
                          std::holds_alternative<BringUpOptions>(command);
  return is_endless ? 0.0 : kLongest;
}

std::variant<Invocation, Printout> parseCommandLine(int argc, const char* const* argv) {
  Invocation invocation{{}, DoctorOptions{}};
  CLI::App app("Grafts a grasp from one hand onto another.", "handgraft");
  app.set_version_flag("--version", fmt::format("handgraft {}", kVersion));
  app.require_subcommand(1);
  CommonOptions& common = invocation.common;
  app.add_option("--domain", common.network.domain, "DDS domain, 0-100")
      ->envname("HANDGRAFT_DOMAIN")
      ->capture_default_str();
  app.add_option("--interface", common.network.interface,
                 "Network interface to meet on: name, address or auto")
      ->envname("HANDGRAFT_INTERFACE")
      ->capture_default_str();
  app.add_option("--peers", common.network.peers,
                 "Hosts to look for servers on, where multicast is dropped")
      ->envname("HANDGRAFT_PEERS")
      ->delimiter(',')
      ->allow_extra_args(false);
  app.add_option("--server", common.network.server,
                 "Name of the server to ask, where a domain has several")
      ->envname("HANDGRAFT_SERVER");
  app.add_option(
         "--identity", common.network.identity,
         "Folder of the identity by which to take part in a secured domain (handgraft keys)")
      ->envname("HANDGRAFT_IDENTITY");
  app.add_flag("--json", common.json, "Print one JSON document");
  app.add_option("--timeout", common.timeout_s,
                 "Seconds after which a command that is not done ends, 0.1-1e6; default: an "
                 "hour, where it does not follow what others do")
      ->check(CLI::Range(0.1, 1e6));

  app.add_subcommand("doctor", "Say whether all is well, and what to do if not");
  addModelCommands(app, invocation.command);
  addImportCommands(app, invocation.command);
  addGraspCommand(app, invocation.command);
  addEditorCommands(app, invocation.command);
  addViewCommand(app, invocation.command);
  addSessionCommands(app, invocation.command);
  addBridgeCommands(app, invocation.command);
  addStudyCommands(app, invocation.command);
  addMotionCommands(app, invocation.command);
  addKeysCommands(app, invocation.command);
  for (CLI::App* command : app.get_subcommands({}))
    command->fallthrough();

  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& success) {
    std::ostringstream text;
    app.exit(success, text, text);
    return Printout{text.str()};
  } catch (const CLI::ParseError& error) {
    const std::vector<std::string> rest = app.remaining(true);
    if (app.get_subcommands().empty() && !rest.empty()) {
      rejectInput("{} is no command; there are {}", quoted(rest.front()), commandsOf(app));
    }
    // CLI11 misses `--hand` before it minds `--hnad`; the slip is what the user wants to know.
    for (const std::string& word : rest) {
      if (word.rfind("--", 0) == 0) {
        rejectInput("there is no option {} (handgraft --help tells more)", quoted(word));
      }
    }
    for (const CLI::App* command : app.get_subcommands()) {
      if (command->get_require_subcommand_min() == 0 || !command->get_subcommands().empty())
        continue;
      rejectInput("{}: one of {} must follow", command->get_name(), commandsOf(*command));
    }
    if (dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr && !rest.empty())
      requireOneWordEach(rest.front(), argc, argv);
    rejectInput("{} (handgraft --help tells more)", oneLine(error.what()));
  }
  validate(common.network);
  return invocation;
}

}  // namespace handgraft::client
