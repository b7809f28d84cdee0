#include "client/command_line.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <sstream>

#include <CLI/CLI.hpp>

#include "client/model_files.h"
#include "client/version.h"
#include "core/base/error.h"

namespace handgraft::client {

namespace {

const std::map<std::string, v1::ModelKind> kKinds = {
    {"hand", v1::MODEL_HAND}, {"object", v1::MODEL_OBJECT}, {"contacts", v1::MODEL_CONTACTS}};

// Everything that CLI11 writes into, in one place, since it keeps references until it has
// parsed.
struct Parsed {
  CommonOptions common;
  ModelsOptions::Show show;
  LoadOptions load;
  GraspOptions grasp;
  WatchOptions watch;
  TransferOptions transfer;
  SuggestOptions suggest;
  CloseOptions close;
  UnloadOptions unload;
  std::string kind;
  std::string path;
  std::string out;
  std::string png;
  std::string problem;
  std::vector<std::string> packages;
  std::vector<double> place;
  std::vector<double> weights;
};

v1::ModelKind kindOf(const std::string& name) {
  const auto found = kKinds.find(name);
  if (found == kKinds.end()) {
    rejectInput("kind {}: it is hand, object or contacts", quoted(name));
  }
  return found->second;
}

PackageMap packagesOf(const std::vector<std::string>& pairs) {
  PackageMap packages;
  for (const std::string& pair : pairs) {
    const std::size_t sign = pair.find('=');
    if (sign == std::string::npos || sign == 0 || sign + 1 == pair.size()) {
      rejectInput("--package {}: write NAME=DIR", quoted(pair));
    }
    const std::filesystem::path directory = pair.substr(sign + 1);
    std::error_code error;
    if (!std::filesystem::is_directory(directory, error)) {
      rejectInput("--package {}: there is no folder {}", pair.substr(0, sign),
                  quoted(directory.string()));
    }
    packages[pair.substr(0, sign)] = directory;
  }
  return packages;
}

void requireFinite(const std::vector<double>& numbers, const char* option, double least) {
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (std::isfinite(numbers[i]) && numbers[i] >= least) continue;
    rejectInput("{}: number {} is {}; it must be finite{}", option, i + 1, numbers[i],
                std::isfinite(least) ? " and not negative" : "");
  }
}

GraspOptions graspOf(const Parsed& parsed) {
  GraspOptions grasp = parsed.grasp;
  const auto requireModel = [](const std::string& text, const char* option) {
    if (!isPath(text)) checkModelName(text, option);
  };
  requireModel(grasp.hand, "--hand");
  requireModel(grasp.object, "--object");
  requireModel(grasp.contacts, "--contacts");
  requireFinite(parsed.place, "--place", -std::numeric_limits<double>::infinity());
  requireFinite(parsed.weights, "--weights", 0.0);
  const auto isZero = [](double weight) {
    return weight == 0.0;
  };
  if (!parsed.weights.empty() &&
      std::all_of(parsed.weights.begin(), parsed.weights.end(), isZero)) {
    rejectInput("--weights 0 0 0: at least one of them must be positive");
  }
  if (!parsed.place.empty()) {
    std::copy_n(parsed.place.begin(), 7, grasp.place.emplace().begin());
  }
  if (!parsed.weights.empty()) {
    std::copy_n(parsed.weights.begin(), 3, grasp.weights.emplace().begin());
  }
  grasp.out = parsed.out;
  grasp.png = parsed.png;
  grasp.problem = parsed.problem;
  grasp.packages = packagesOf(parsed.packages);
  return grasp;
}

LoadOptions loadOf(const Parsed& parsed) {
  LoadOptions load = parsed.load;
  load.kind = kindOf(parsed.kind);
  load.path = parsed.path;
  load.packages = packagesOf(parsed.packages);
  if (!load.name.empty()) checkModelName(load.name, "--name");
  if (!load.object.empty()) {
    checkModelName(load.object, "--object");
    if (load.kind != v1::MODEL_CONTACTS) {
      rejectInput("--object {}: only contacts lie on an object", load.object);
    }
  }
  return load;
}

// CLI11 itself would wrap -1 to the largest number.
std::string objectionToCount(const std::string& text) {
  std::uint64_t number = 0;
  const char* end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, number);
  if (error == std::errc() && rest == end) return "";
  return quoted(text) + " is no whole number from 0 to 2^64 - 1";
}

std::string objectionToFile(const std::string& name) {
  return name.empty() ? "the file's name is empty" : "";
}

void addGrasp(CLI::App& app, Parsed& parsed) {
  GraspOptions& grasp = parsed.grasp;
  CLI::App* command =
      app.add_subcommand("grasp", "Lay contacts onto a hand and solve its pose");
  command->add_option("--hand", grasp.hand, "Model name, or path of a URDF")->required();
  command->add_option("--object", grasp.object, "Model name, or path of a mesh")->required();
  command->add_option("--contacts", grasp.contacts, "Model name, or path of a JSON or PLY file")
      ->required();
  command
      ->add_option("--place", parsed.place,
                   "The object's pose in the world: x y z (m) qw qx qy qz")
      ->expected(7);
  command->add_option("--solver", grasp.solver,
                      "mma (default), ccsaq, slsqp, lbfgs, tnewton, var2");
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
  command->add_option("--weights", parsed.weights, "Of distance (1/m^2), normal and prior")
      ->expected(3);
  command->add_option("--out", parsed.out, "Write the result as JSON")->check(objectionToFile);
  command->add_option("--png", parsed.png, "Write a picture from two sides")
      ->check(objectionToFile);
  command
      ->add_option("--problem", parsed.problem, "Write what was solved as handgraft-problem/1")
      ->check(objectionToFile);
  command->add_option("--package", parsed.packages, "NAME=DIR: where package://NAME leads");
  command->add_flag("--keep", grasp.keep, "Leave the session open and print its id");
}

void addTransfer(CLI::App& app, Parsed& parsed) {
  CLI::App* command =
      app.add_subcommand("transfer", "Say how each patch of a session lies on the hand");
  command->add_option("session", parsed.transfer.session_id, "Its id")
      ->required()
      ->check(objectionToCount);
}

void addSuggest(CLI::App& app, Parsed& parsed) {
  SuggestOptions& suggest = parsed.suggest;
  CLI::App* command = app.add_subcommand(
      "suggest", "Look nearby for a place on the hand where a patch loses fewer points");
  command->add_option("session", suggest.session_id, "Its id")
      ->required()
      ->check(objectionToCount);
  command->add_option("patch", suggest.patch, "The patch's name")->required();
  command->add_option("--reach", suggest.reach_mm, "How far its root may move in mm: 0.1-100");
  command->add_option("--count", suggest.count, "Suggestions at most: 1-100")
      ->check(objectionToCount);
  command->add_option("--apply", suggest.apply, "Apply the suggestion of this number")
      ->check(objectionToCount);
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

void addLoad(CLI::App& app, Parsed& parsed) {
  CLI::App* command = app.add_subcommand("load", "Send a model's files to the server");
  command->add_option("kind", parsed.kind, "hand, object or contacts")->required();
  command->add_option("path", parsed.path, "URDF, mesh, contact set or contact map")
      ->required();
  command->add_option("--name", parsed.load.name, "What to call it; default: the file's name");
  command->add_option("--object", parsed.load.object, "Contacts: the object that they lie on");
  command->add_option("--package", parsed.packages, "NAME=DIR: where package://NAME leads");
}

void addModels(CLI::App& app, Parsed& parsed) {
  CLI::App* command = app.add_subcommand("models", "List the server's models");
  CLI::App* show = command->add_subcommand("show", "Describe one model");
  show->add_option("kind", parsed.kind, "hand, object or contacts")->required();
  show->add_option("name", parsed.show.name, "Its name")->required();
  show->fallthrough();
}

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

}  // namespace

std::variant<Invocation, Printout> parseCommandLine(int argc, const char* const* argv) {
  Parsed parsed;
  CLI::App app("Grafts a grasp from one hand onto another.", "handgraft");
  app.set_version_flag("--version", fmt::format("handgraft {}", kVersion));
  app.require_subcommand(1);
  app.add_option("--domain", parsed.common.network.domain, "DDS domain, 0-100")
      ->capture_default_str();
  app.add_option("--interface", parsed.common.network.interface, "Network interface to meet on")
      ->capture_default_str();
  app.add_flag("--json", parsed.common.json, "Print one JSON document");

  app.add_subcommand("doctor", "Say whether all is well, and what to do if not");
  addModels(app, parsed);
  addLoad(app, parsed);
  addGrasp(app, parsed);
  app.add_subcommand("sessions", "List the server's sessions");
  CLI::App* watch = app.add_subcommand("watch", "Follow a session's states and solutions");
  watch->add_option("session", parsed.watch.session_id, "Its id")
      ->required()
      ->check(objectionToCount);
  watch->add_option("--count", parsed.watch.count, "Stop after so many solutions; 0: never")
      ->check(objectionToCount);
  addTransfer(app, parsed);
  addSuggest(app, parsed);
  CLI::App* close = app.add_subcommand("close", "End a session");
  close->add_option("session", parsed.close.session_id, "Its id")
      ->required()
      ->check(objectionToCount);
  CLI::App* unload = app.add_subcommand("unload", "Have the server forget a model");
  unload->add_option("kind", parsed.kind, "hand, object or contacts")->required();
  unload->add_option("name", parsed.unload.name, "Its name")->required();
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
    rejectInput("{} (handgraft --help tells more)", oneLine(error.what()));
  }
  validate(parsed.common.network);

  const std::string command = app.get_subcommands().front()->get_name();
  Invocation invocation{parsed.common, DoctorOptions{}};
  if (command == "models") {
    ModelsOptions models;
    if (app.get_subcommand("models")->got_subcommand("show")) {
      checkModelName(parsed.show.name, "name");
      models.show = {kindOf(parsed.kind), parsed.show.name};
    }
    invocation.command = models;
  } else if (command == "load") {
    invocation.command = loadOf(parsed);
  } else if (command == "grasp") {
    invocation.command = graspOf(parsed);
  } else if (command == "sessions") {
    invocation.command = SessionsOptions{};
  } else if (command == "watch") {
    invocation.command = parsed.watch;
  } else if (command == "transfer") {
    invocation.command = parsed.transfer;
  } else if (command == "suggest") {
    requireSound(*app.get_subcommand("suggest"), parsed.suggest);
    invocation.command = parsed.suggest;
  } else if (command == "close") {
    invocation.command = parsed.close;
  } else if (command == "unload") {
    checkModelName(parsed.unload.name, "name");
    invocation.command = UnloadOptions{kindOf(parsed.kind), parsed.unload.name};
  }
  return invocation;
}

}  // namespace handgraft::client
