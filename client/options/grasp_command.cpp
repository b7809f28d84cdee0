#include <algorithm>
#include <memory>

#include <CLI/CLI.hpp>

#include "client/options/command_options.h"
#include "client/options/model_flags.h"
#include "client/options/option_checks.h"
#include "core/base/error.h"

namespace handgraft::client {

namespace {

struct Parsed {
  GraspOptions grasp;
  std::string out;
  std::string png;
  std::string problem;
  std::vector<double> place;
  std::vector<double> weights;
  HandFlags hand;
  ContactFlags contacts;
};

GraspOptions graspOf(const Parsed& parsed) {
  GraspOptions grasp = parsed.grasp;
  requireModel(grasp.hand, "--hand");
  requireModel(grasp.object, "--object");
  requireModel(grasp.contacts, "--contacts");
  if (!grasp.units.empty() && !isPath(grasp.object) && !isPath(grasp.contacts)) {
    rejectInput("--units {}: neither --object nor --contacts is a file", grasp.units);
  }
  grasp.hand_reading = parsed.hand.reading();
  grasp.contact_reading = parsed.contacts.reading();
  parsed.hand.requirePath(grasp.hand, "--hand");
  parsed.contacts.requirePath(grasp.contacts, "--contacts");
  grasp.place = placeOf(parsed.place);
  requireFinite(parsed.weights, "--weights", 0.0);
  const auto isZero = [](double weight) {
    return weight == 0.0;
  };
  if (!parsed.weights.empty()) {
    if (std::all_of(parsed.weights.begin(), parsed.weights.end(), isZero)) {
      rejectInput("--weights 0 0 0: at least one of them must be positive");
    }
    std::copy_n(parsed.weights.begin(), 3, grasp.weights.emplace().begin());
  }
  grasp.out = parsed.out;
  grasp.png = parsed.png;
  grasp.problem = parsed.problem;
  return grasp;
}

}  // namespace

void addGraspCommand(CLI::App& app, CommandOptions& chosen) {
  const auto parsed = std::make_shared<Parsed>();
  GraspOptions& grasp = parsed->grasp;
  CLI::App* command =
      app.add_subcommand("grasp", "Lay contacts onto a hand and solve its pose");
  command->add_option("--hand", grasp.hand, "Model name, or path of a URDF")->required();
  command->add_option("--object", grasp.object, "Model name, or path of a mesh")->required();
  command->add_option("--contacts", grasp.contacts, "Model name, or path of a JSON or PLY file")
      ->required();
  command
      ->add_option("--place", parsed->place,
                   "The object's pose in the world: x y z (m) qw qx qy qz")
      ->expected(7);
  command->add_option("--solver", grasp.solver,
                      "lm (default), mma, ccsaq, slsqp, lbfgs, tnewton, var2; all races them");
  command->add_option("--starts", grasp.starts, "Number of starts; 0: the server's default")
      ->check(objectionToCount);
  command->add_option("--seed", grasp.seed, "Seed of the starts after the first")
      ->check(objectionToCount);
  command->add_option("--log-map", grasp.log_map,
                      "How patches are laid out: fast, exact, auto, smooth, heat");
  command
      ->add_option("--interior", grasp.interior_rings,
                   "Rings of points inside each patch that count, too: 0 (default) to 16")
      ->check(objectionToCount);
  command->add_option("--weights", parsed->weights, "Of distance (1/m^2), normal and prior")
      ->expected(3);
  command->add_option("--out", parsed->out, "Write the result as JSON")->check(objectionToFile);
  command->add_option("--png", parsed->png, "Write a picture from two sides")
      ->check(objectionToFile);
  command
      ->add_option("--problem", parsed->problem, "Write what was solved as handgraft-problem/1")
      ->check(objectionToFile);
  command->add_flag("--keep", grasp.keep, "Leave the session open and print its id");
  addUnits(*command, grasp.units, "the object and the contacts");
  parsed->hand.addTo(*command);
  parsed->contacts.addSourceTo(*command);
  parsed->contacts.addSegmentationTo(*command);
  command->callback([parsed, &chosen] {
    chosen = graspOf(*parsed);
  });
}

}  // namespace handgraft::client
