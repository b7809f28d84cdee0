#include <algorithm>
#include <memory>

#include <CLI/CLI.hpp>

#include "client/cli/options/command_options.h"
#include "client/cli/options/model_flags.h"
#include "client/cli/options/option_checks.h"
#include "core/base/error.h"

namespace handgraft::client {

namespace {

struct ParsedVary {
  VaryOptions vary;
  std::vector<std::string> changes;
  std::string urdf;
  HandFlags hand;
};

VaryOptions varyOf(const ParsedVary& parsed) {
  VaryOptions vary = parsed.vary;
  requireModel(vary.hand, "hand");
  parsed.hand.requirePath(vary.hand, "hand");
  if (!vary.units.empty() && !isPath(vary.hand)) {
    rejectInput("--units {}: hand {} has been read already; it is for files", vary.units,
                vary.hand);
  }
  checkModelName(vary.name, "--name");
  vary.reading = parsed.hand.reading();
  for (const std::string& text : parsed.changes)
    vary.changes.push_back(changeFrom(text));
  vary.urdf = parsed.urdf;
  return vary;
}

struct ParsedSweep {
  SweepOptions sweep;
  std::string contacts;
  std::string objects;
  std::vector<std::string> motions;
  std::vector<std::string> axes;
  std::vector<double> weights;
  std::string out;
  std::string png;
  HandFlags hand;
  ContactFlags contact_flags;
};

SweepOptions sweepOf(const ParsedSweep& parsed) {
  SweepOptions sweep = parsed.sweep;
  requireModel(sweep.hand, "--hand");
  parsed.hand.requirePath(sweep.hand, "--hand");
  sweep.hand_reading = parsed.hand.reading();
  sweep.contact_reading = parsed.contact_flags.reading();
  if (!sweep.folders.object.empty()) {
    requireModel(sweep.folders.object, "--object");
    if (!parsed.objects.empty()) {
      rejectInput("--object {} and --object-dir {}: one of them says what the contacts lie on",
                  sweep.folders.object, parsed.objects);
    }
  }
  sweep.folders.contacts = parsed.contacts;
  sweep.folders.motions = parsed.motions;
  for (const std::string& motion : parsed.motions)
    requireModel(motion, "--motion");
  if (parsed.contacts.empty() && parsed.motions.empty())
    rejectInput("neither --contacts-dir nor --motion says what to solve");
  sweep.folders.objects = parsed.objects;
  for (const std::string& text : parsed.axes) {
    sweep.axes.push_back(axisFrom(text));
    const std::string& name = sweep.axes.back().name;
    const auto same =
        std::count_if(sweep.axes.begin(), sweep.axes.end(), [&](const StudyAxis& other) {
          return other.name == name;
        });
    if (same > 1) rejectInput("--vary {}: {} is varied already", text, name);
  }
  requireFinite(parsed.weights, "--weights", 0.0);
  if (!parsed.weights.empty())
    std::copy_n(parsed.weights.begin(), 3, sweep.weights.emplace().begin());
  sweep.out = parsed.out;
  sweep.png = parsed.png;
  if (!sweep.png.empty() && sweep.axes.size() > 2) {
    rejectInput("--png {}: a picture shows one property or two; {} are varied", parsed.png,
                sweep.axes.size());
  }
  return sweep;
}

}  // namespace

void addVary(CLI::App& hand, CommandOptions& chosen) {
  const auto parsed = std::make_shared<ParsedVary>();
  CLI::App* command = hand.add_subcommand(
      "vary", "Make a hand like another one with other limits, lengths or sizes");
  command->add_option("hand", parsed->vary.hand, "Model name, or path of a URDF")->required();
  command
      ->add_option("--set", parsed->changes,
                   "JOINT.lower=V, JOINT.upper=V, JOINT.range=F, LINK.length=F, LINK.size=F, "
                   "hand.size=F; once a change, in order")
      ->required();
  command->add_option("--name", parsed->vary.name, "What to call it")->required();
  command->add_option("--urdf", parsed->urdf, "Write its links and joints")
      ->check(objectionToFile);
  addUnits(*command, parsed->vary.units, "the meshes");
  parsed->hand.addTo(*command);
  command->fallthrough();
  command->callback([parsed, &chosen] {
    chosen = varyOf(*parsed);
  });
}

void addStudyCommands(CLI::App& app, CommandOptions& chosen) {
  const auto parsed = std::make_shared<ParsedSweep>();
  SweepOptions& sweep = parsed->sweep;
  CLI::App* command = app.add_subcommand(
      "sweep", "Solve grasps and motions for many values of a hand's limits, lengths or sizes");
  command->add_option("--hand", sweep.hand, "Model name, or path of a URDF")->required();
  command->add_option("--contacts-dir", parsed->contacts, "Folder of contact sets and motions");
  command->add_option("--motion", parsed->motions,
                      "Model name, or path of a motion; once or more");
  command->add_option("--object-dir", parsed->objects,
                      "Folder of the objects they name; default: beside them, then the server");
  command->add_option("--object", sweep.folders.object,
                      "Model name, or path of a mesh, that all of them lie on");
  command
      ->add_option("--vary", parsed->axes,
                   "JOINT.upper=FROM:TO:COUNT or =A,B,C; also lower, range, LINK.length, "
                   "LINK.size, hand.size; angles may end in deg; once a property")
      ->required();
  command
      ->add_option("--solver", sweep.solver,
                   "lm (default), mma, ccsaq, slsqp, lbfgs, tnewton, var2; all races them")
      ->check(objectionToSolver);
  command->add_option("--starts", sweep.starts, "Number of starts; 0: the server's default")
      ->check(objectionToSmallCount);
  command->add_option("--seed", sweep.seed, "Seed of the starts after the first")
      ->check(objectionToSmallCount);
  command->add_option("--weights", parsed->weights, "Of distance (1/m^2), normal and prior")
      ->expected(3);
  command->add_option("--log-map", sweep.log_map,
                      "How patches are laid out: fast, exact, auto, smooth, heat");
  command->add_option("--out", parsed->out, "Write a row a grasp and value as CSV")
      ->check(objectionToFile);
  command->add_option("--png", parsed->png, "Draw the distances over the values")
      ->check(objectionToPng);
  addUnits(*command, sweep.units, "objects and contact maps");
  parsed->hand.addTo(*command);
  parsed->contact_flags.addSourceTo(*command);
  parsed->contact_flags.addSegmentationTo(*command);
  command->callback([parsed, &chosen] {
    chosen = sweepOf(*parsed);
  });
}

}  // namespace handgraft::client
