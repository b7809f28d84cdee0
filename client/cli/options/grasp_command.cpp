#include <memory>
#include <optional>

#include <CLI/CLI.hpp>

#include "client/cli/options/command_options.h"
#include "client/cli/options/grasp_flags.h"
#include "client/cli/options/option_checks.h"
#include "core/base/error.h"

namespace handgraft::client {

namespace {

struct Parsed {
  GraspFlags flags;
  std::string out;
  std::string png;
  std::string problem;
  std::optional<std::uint32_t> choose;
  bool keep = false;
};

GraspOptions graspOf(const Parsed& parsed) {
  GraspOptions grasp = parsed.flags.grasp();
  grasp.out = parsed.out;
  grasp.png = parsed.png;
  grasp.problem = parsed.problem;
  grasp.keep = parsed.keep;
  if (parsed.choose) {
    constexpr std::uint32_t kMostRanks = 8;  // idl/sessions.idl, minima
    if (*parsed.choose < 1 || *parsed.choose > kMostRanks) {
      rejectInput("--choose {}: it must lie in 1 to {}", *parsed.choose, kMostRanks);
    }
    if (grasp.paper) rejectInput("--choose {}: --paper has one result", *parsed.choose);
    grasp.choose = *parsed.choose;
  }
  return grasp;
}

}  // namespace

void addGraspCommand(CLI::App& app, CommandOptions& chosen) {
  const auto parsed = std::make_shared<Parsed>();
  CLI::App* command =
      app.add_subcommand("grasp", "Lay contacts onto a hand and solve its pose");
  parsed->flags.addTo(*command);
  command->add_option("--out", parsed->out, "Write the result as JSON")->check(objectionToFile);
  command->add_option("--png", parsed->png, "Write a picture from two sides")
      ->check(objectionToPng);
  command
      ->add_option("--problem", parsed->problem, "Write what was solved as handgraft-problem/1")
      ->check(objectionToFile);
  command
      ->add_option("--choose", parsed->choose,
                   "Take the result of this rank, from 1, among those that the searches found")
      ->check(objectionToCount);
  command->add_flag("--keep", parsed->keep, "Leave the session open and print its id");
  command->callback([parsed, &chosen] {
    chosen = graspOf(*parsed);
  });
}

}  // namespace handgraft::client
