#include <memory>

#include <CLI/CLI.hpp>

#include "client/cli/options/command_options.h"
#include "client/cli/options/model_flags.h"
#include "client/cli/options/option_checks.h"
#include "core/base/error.h"

namespace handgraft::client {

namespace {

// What `hand inspect` and `skin` have in common.
struct ParsedHand {
  std::string hand;
  std::string units;
  std::string out;
  std::string png;
  HandFlags flags;

  void addTo(CLI::App& command) {
    command.add_option("hand", hand, "Model name, or path of a URDF")->required();
    command.add_option("--png", png, "Write a picture from two sides")->check(objectionToPng);
    addUnits(command, units, "the meshes");
    flags.addTo(command);
  }

  void check() const {
    requireModel(hand, "hand");
    flags.requirePath(hand, "hand");
    if (!units.empty() && !isPath(hand)) {
      rejectInput("--units {}: hand {} has been read already; it is for files", units, hand);
    }
  }
};

CLI::App& addInspect(CLI::App& app, CommandOptions& chosen) {
  const auto parsed = std::make_shared<ParsedHand>();
  CLI::App* command = app.add_subcommand("hand", "Look at a hand");
  command->require_subcommand(1);
  CLI::App* inspect = command->add_subcommand(
      "inspect",
      "Tell a hand's joints, sites and skin; draw them; write the sites for editing");
  parsed->addTo(*inspect);
  inspect->add_option("--sites", parsed->out, "Write the sites as YAML, for editing")
      ->check(objectionToFile);
  inspect->fallthrough();
  inspect->callback([parsed, &chosen] {
    parsed->check();
    chosen = InspectOptions{parsed->hand, parsed->flags.reading(), parsed->units, parsed->png,
                            parsed->out};
  });
  return *command;
}

void addSkin(CLI::App& app, CommandOptions& chosen) {
  const auto parsed = std::make_shared<ParsedHand>();
  CLI::App* command = app.add_subcommand("skin", "Make a hand's skin and write it as a PLY");
  parsed->addTo(*command);
  command->add_option("--out", parsed->out, "The PLY to write")
      ->required()
      ->check(objectionToFile);
  command->callback([parsed, &chosen] {
    parsed->check();
    chosen = SkinOptions{parsed->hand, parsed->flags.reading(), parsed->units, parsed->out,
                         parsed->png};
  });
}

// What the two ways to contacts have in common.
struct ParsedContacts {
  std::string map;
  std::string hand;
  std::string pose;
  std::string object;
  std::string units;
  std::string name;
  std::string out;
  std::string png;
  std::vector<double> place;
  std::optional<double> reach_mm;
  HandFlags hand_flags;
  ContactFlags flags;

  void addTo(CLI::App& command) {
    command.add_option("--object", object, "Model name, or path of a mesh")->required();
    command.add_option("--name", name, "What to call the contacts");
    command.add_option("--out", out, "Write them as a contact set, for editing")
        ->check(objectionToFile);
    command.add_option("--png", png, "Write a picture from two sides")->check(objectionToPng);
  }

  void check() const {
    requireModel(object, "--object");
    if (!name.empty()) checkModelName(name, "--name");
  }
};

void addImport(CLI::App& app, CommandOptions& chosen) {
  const auto parsed = std::make_shared<ParsedContacts>();
  CLI::App* command =
      app.add_subcommand("import", "Find the patches of a contact map, e.g. a scan");
  command
      ->add_option("map", parsed->map,
                   "PLY; OBJ with colours; glTF and the like with --picture; JSON")
      ->required();
  parsed->addTo(*command);
  addUnits(*command, parsed->units, "the map and the object");
  parsed->flags.addSourceTo(*command, "--joints-hand,--hand");
  parsed->flags.addSegmentationTo(*command);
  command->fallthrough();
  command->callback([parsed, &chosen] {
    parsed->check();
    chosen = ImportOptions{parsed->map,   parsed->object, parsed->flags.reading(),
                           parsed->units, parsed->name,   parsed->out,
                           parsed->png};
  });
}

PoseContactsOptions poseContactsOf(const ParsedContacts& parsed) {
  parsed.check();
  requireModel(parsed.hand, "--hand");
  parsed.hand_flags.requirePath(parsed.hand, "--hand");
  if (!parsed.units.empty() && !isPath(parsed.object)) {
    rejectInput("--units {}: object {} has been read already; it is for files", parsed.units,
                parsed.object);
  }
  PoseContactsOptions options;
  options.hand = parsed.hand;
  options.reading = parsed.hand_flags.reading();
  options.pose = parsed.pose;
  options.object = parsed.object;
  options.units = parsed.units;
  options.place = placeOf(parsed.place);
  options.reach_mm = scaled(parsed.reach_mm, "--reach", 0.1, 100.0, 1.0);
  options.contacts = parsed.flags.reading().options;
  options.name = parsed.name;
  options.out = parsed.out;
  options.png = parsed.png;
  return options;
}

void addFromPose(CLI::App& app, CommandOptions& chosen) {
  const auto parsed = std::make_shared<ParsedContacts>();
  CLI::App* command =
      app.add_subcommand("from-pose", "Find what a posed hand touches of an object");
  command->add_option("--hand", parsed->hand, "Model name, or path of a URDF")->required();
  command
      ->add_option(
          "--pose", parsed->pose,
          "A result of grasp --out, a file of joints, a named pose of the hand, or rest")
      ->required();
  command
      ->add_option("--place", parsed->place,
                   "The object's pose in the world: x y z (m) qw qx qy qz")
      ->expected(7);
  command->add_option("--reach", parsed->reach_mm,
                      "How far from the hand contact ends: 0.1-100 mm, default 10");
  parsed->addTo(*command);
  addUnits(*command, parsed->units, "the object");
  parsed->hand_flags.addTo(*command);
  parsed->flags.addSegmentationTo(*command);
  command->fallthrough();
  command->callback([parsed, &chosen] {
    chosen = poseContactsOf(*parsed);
  });
}

}  // namespace

void addImportCommands(CLI::App& app, CommandOptions& chosen) {
  addVary(addInspect(app, chosen), chosen);
  addSkin(app, chosen);
  CLI::App* contacts = app.add_subcommand("contacts", "Make contact sets");
  contacts->require_subcommand(1);
  addImport(*contacts, chosen);
  addFromPose(*contacts, chosen);
}

}  // namespace handgraft::client
