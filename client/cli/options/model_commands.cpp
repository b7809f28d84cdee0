#include <memory>

#include <CLI/CLI.hpp>

#include "client/cli/options/command_options.h"
#include "client/cli/options/model_flags.h"
#include "client/cli/options/option_checks.h"
#include "core/base/error.h"

namespace handgraft::client {

namespace {

struct ParsedLoad {
  LoadOptions load;
  std::string kind;
  std::string path;
  HandFlags hand;
  ContactFlags contacts;
};

LoadOptions loadOf(const ParsedLoad& parsed) {
  LoadOptions load = parsed.load;
  load.kind = kindOf(parsed.kind);
  load.path = parsed.path;
  load.hand_reading = parsed.hand.reading();
  load.contact_reading = parsed.contacts.reading();
  if (!load.name.empty()) checkModelName(load.name, "--name");
  if (load.kind != v1::MODEL_HAND) parsed.hand.requireUnused("hands");
  if (load.kind != v1::MODEL_CONTACTS) parsed.contacts.requireUnused("contact maps");
  if (!load.object.empty()) {
    checkModelName(load.object, "--object");
    if (load.kind != v1::MODEL_CONTACTS && load.kind != v1::MODEL_MOTION) {
      rejectInput("--object {}: only contacts and motions lie on an object", load.object);
    }
  }
  return load;
}

void addLoad(CLI::App& app, CommandOptions& chosen) {
  const auto parsed = std::make_shared<ParsedLoad>();
  CLI::App* command = app.add_subcommand("load", "Send a model's files to the server");
  command->add_option("kind", parsed->kind, "hand, object, contacts or motion")->required();
  command->add_option("path", parsed->path, "URDF, mesh, contact set, contact map or motion")
      ->required();
  command->add_option("--name", parsed->load.name, "What to call it; default: the file's name");
  command->add_option("--object", parsed->load.object,
                      "Contacts, motions: the object that they lie on");
  addUnits(*command, parsed->load.units, "meshes and maps");
  parsed->hand.addTo(*command);
  parsed->contacts.addSourceTo(*command);
  parsed->contacts.addSegmentationTo(*command);
  command->callback([parsed, &chosen] {
    chosen = loadOf(*parsed);
  });
}

void addModels(CLI::App& app, CommandOptions& chosen) {
  struct Parsed {
    std::string kind;
    std::string name;
  };

  const auto parsed = std::make_shared<Parsed>();
  CLI::App* command = app.add_subcommand("models", "List the server's models");
  CLI::App* show = command->add_subcommand("show", "Describe one model");
  show->add_option("kind", parsed->kind, "hand, object, contacts or motion")->required();
  show->add_option("name", parsed->name, "Its name")->required();
  show->fallthrough();
  command->callback([parsed, command, &chosen] {
    ModelsOptions models;
    if (command->got_subcommand("show")) {
      checkModelName(parsed->name, "name");
      models.show = {kindOf(parsed->kind), parsed->name};
    }
    chosen = models;
  });
}

void addUnload(CLI::App& app, CommandOptions& chosen) {
  struct Parsed {
    std::string kind;
    std::string name;
  };

  const auto parsed = std::make_shared<Parsed>();
  CLI::App* command = app.add_subcommand("unload", "Have the server forget a model");
  command->add_option("kind", parsed->kind, "hand, object, contacts or motion")->required();
  command->add_option("name", parsed->name, "Its name")->required();
  command->callback([parsed, &chosen] {
    checkModelName(parsed->name, "name");
    chosen = UnloadOptions{kindOf(parsed->kind), parsed->name};
  });
}

}  // namespace

void addModelCommands(CLI::App& app, CommandOptions& chosen) {
  addModels(app, chosen);
  addLoad(app, chosen);
  addUnload(app, chosen);
}

}  // namespace handgraft::client
