#include <memory>

#include <CLI/CLI.hpp>

#include "client/cli/options/command_options.h"
#include "client/cli/options/option_checks.h"
#include "core/base/error.h"

namespace handgraft::client {

namespace {

void addSessionId(CLI::App& command, std::uint64_t& session_id) {
  command.add_option("session", session_id, "Its id, or the first digits of it, at least four")
      ->required()
      ->check(objectionToCount);
}

void addWatch(CLI::App& app, CommandOptions& chosen) {
  const auto parsed = std::make_shared<WatchOptions>();
  CLI::App* command = app.add_subcommand("watch", "Follow a session's states and solutions");
  addSessionId(*command, parsed->session_id);
  command
      ->add_option("--count", parsed->count,
                   "Stop after so many solutions that are diagnosed; 0: never")
      ->check(objectionToCount);
  command->callback([parsed, &chosen] {
    chosen = *parsed;
  });
}

void addTransfer(CLI::App& app, CommandOptions& chosen) {
  const auto parsed = std::make_shared<TransferOptions>();
  CLI::App* command =
      app.add_subcommand("transfer", "Say how each patch of a session lies on the hand");
  addSessionId(*command, parsed->session_id);
  command->callback([parsed, &chosen] {
    chosen = *parsed;
  });
}

void requireSound(const CLI::App& command, const SuggestOptions& suggest) {
  if (command.count("--reach") > 0 && !(suggest.reach_mm >= 0.1 && suggest.reach_mm <= 100.0)) {
    rejectInput("--reach {}: it must be 0.1 to 100 mm", suggest.reach_mm);
  }
  if (command.count("--count") > 0 && (suggest.count < 1 || suggest.count > 100)) {
    rejectInput("--count {}: it must be 1 to 100", suggest.count);
  }
  if (command.count("--apply") > 0 && suggest.apply < 1) {
    rejectInput("--apply 0: suggestions count from 1");
  }
}

void addSuggest(CLI::App& app, CommandOptions& chosen) {
  const auto parsed = std::make_shared<SuggestOptions>();
  CLI::App* command = app.add_subcommand(
      "suggest", "Look nearby for a place on the hand where a patch loses fewer points");
  addSessionId(*command, parsed->session_id);
  command->add_option("patch", parsed->patch, "The patch's name")->required();
  command->add_option("--reach", parsed->reach_mm, "How far its root may move in mm: 0.1-100");
  command->add_option("--count", parsed->count, "Suggestions at most: 1-100")
      ->check(objectionToCount);
  command->add_option("--apply", parsed->apply, "Apply the suggestion of this number")
      ->check(objectionToCount);
  command->callback([parsed, command, &chosen] {
    requireSound(*command, *parsed);
    chosen = *parsed;
  });
}

void addClose(CLI::App& app, CommandOptions& chosen) {
  const auto parsed = std::make_shared<CloseOptions>();
  CLI::App* command = app.add_subcommand("close", "End a session");
  addSessionId(*command, parsed->session_id);
  command->callback([parsed, &chosen] {
    chosen = *parsed;
  });
}

}  // namespace

void addSessionCommands(CLI::App& app, CommandOptions& chosen) {
  app.add_subcommand("sessions", "List the server's sessions")->callback([&chosen] {
    chosen = SessionsOptions{};
  });
  addWatch(app, chosen);
  addTransfer(app, chosen);
  addSuggest(app, chosen);
  addClose(app, chosen);
}

}  // namespace handgraft::client
