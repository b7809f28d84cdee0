#include <memory>

#include <CLI/CLI.hpp>

#include "client/cli/options/command_options.h"
#include "core/base/error.h"

namespace handgraft::client {

namespace {

constexpr const char* kRoleHelp =
    "operator: edits, arms hands, unloads models; editor: edits; viewer: only looks; "
    "hand: a bridge; server: a server";

}  // namespace

void addKeysCommands(CLI::App& app, CommandOptions& chosen) {
  using Action = KeysOptions::Action;
  CLI::App* keys = app.add_subcommand(
      "keys", "Make and take back the identities of a secured domain (--identity)");
  keys->require_subcommand(1);
  const auto add = [&](const char* name, const char* help, Action action) {
    const auto parsed = std::make_shared<KeysOptions>();
    parsed->action = action;
    CLI::App* command = keys->add_subcommand(name, help);
    command->fallthrough();
    command->callback([parsed, &chosen] {
      chosen = *parsed;
    });
    return std::pair(command, parsed);
  };
  const auto add_folder = [](CLI::App* command, KeysOptions& parsed) {
    command
        ->add_option("--dir", parsed.folder,
                     "The authority's folder; default: $XDG_CONFIG_HOME/handgraft/keys or "
                     "~/.config/handgraft/keys")
        ->envname("HANDGRAFT_KEYS");
  };

  const auto [init, init_options] =
      add("init", "Make a certificate authority in a folder of its own", Action::kInit);
  init->add_option("dir", init_options->folder,
                   "The folder; default: $XDG_CONFIG_HOME/handgraft/keys or "
                   "~/.config/handgraft/keys")
      ->envname("HANDGRAFT_KEYS");

  const auto [make, make_options] =
      add("add", "Make an identity: a folder for --identity", Action::kAdd);
  make->add_option("name", make_options->name, "Whose it is")->required();
  make->add_option("--role", make_options->role, kRoleHelp)->required();
  make->add_option("--days", make_options->days, "Until it expires, 1-3650")
      ->capture_default_str();
  add_folder(make, *make_options);

  const auto [show, show_options] =
      add("show", "List the identities, and what is wrong with them", Action::kShow);
  add_folder(show, *show_options);

  const auto [revoke, revoke_options] =
      add("revoke", "Take an identity back, for ever", Action::kRevoke);
  revoke->add_option("name", revoke_options->name, "Whose it is")->required();
  add_folder(revoke, *revoke_options);
}

}  // namespace handgraft::client
