#include <memory>

#include <CLI/CLI.hpp>

#include "client/cli/options/command_options.h"
#include "client/cli/options/option_checks.h"
#include "core/base/error.h"

namespace handgraft::client {

namespace {

using Action = BridgeOptions::Action;

void addBridgeId(CLI::App& command, std::optional<std::uint32_t>& bridge_id) {
  command.add_option("--bridge", bridge_id, "Its number; default: the only one there is")
      ->check(objectionToCount);
}

void addAction(CLI::App& bridge,
               const char* name,
               const char* help,
               Action action,
               CommandOptions& chosen) {
  const auto parsed = std::make_shared<BridgeOptions>();
  parsed->action = action;
  CLI::App* command = bridge.add_subcommand(name, help);
  addBridgeId(*command, parsed->bridge_id);
  command->fallthrough();
  command->callback([parsed, &chosen] {
    chosen = *parsed;
  });
}

void addRecord(CLI::App& bridge, CommandOptions& chosen) {
  struct Parsed {
    BridgeRecordOptions options;
    std::string out, png;
  };

  const auto parsed = std::make_shared<Parsed>();
  CLI::App* command =
      bridge.add_subcommand("record", "Write down what a hand is sent and what it measures");
  addBridgeId(*command, parsed->options.bridge_id);
  command->add_option("--out", parsed->out, "CSV, a row a sample")
      ->required()
      ->check(objectionToFile);
  command->add_option("--seconds", parsed->options.seconds, "How long; 0: until Ctrl-C")
      ->capture_default_str();
  command->add_option("--png", parsed->png, "Draw it as well")->check(objectionToPng);
  command->fallthrough();
  command->callback([parsed, &chosen] {
    requireFinite({parsed->options.seconds}, "--seconds", 0.0);
    parsed->options.out = parsed->out;
    parsed->options.png = parsed->png;
    chosen = parsed->options;
  });
}

void addPlot(CLI::App& bridge, CommandOptions& chosen) {
  struct Parsed {
    std::string run, out;
  };

  const auto parsed = std::make_shared<Parsed>();
  CLI::App* command =
      bridge.add_subcommand("plot", "Draw a recorded run: measured against commanded");
  command->add_option("run", parsed->run, "What `bridge record` wrote")->required();
  command->add_option("--out", parsed->out, "PNG")->required()->check(objectionToPng);
  command->fallthrough();
  command->callback([parsed, &chosen] {
    BridgePlotOptions options;
    options.run = parsed->run;
    options.out = parsed->out;
    chosen = options;
  });
}

// Devices are the bridge program's; its own --help says what there is to tell it.
void addBringUp(CLI::App& parent,
                const char* name,
                const char* help,
                const char* step,
                CommandOptions& chosen) {
  CLI::App* command = parent.add_subcommand(name, help);
  command->prefix_command();
  command->set_help_flag();
  command->callback([command, step, &chosen] {
    BringUpOptions options;
    options.arguments = command->remaining();
    options.arguments.insert(options.arguments.begin(), step);
    chosen = options;
  });
}

}  // namespace

void addBridgeCommands(CLI::App& app, CommandOptions& chosen) {
  CLI::App* bridge = app.add_subcommand("bridge", "Look at and command the bridge to a hand");
  bridge->require_subcommand(1);
  addAction(*bridge, "status", "How all bridges do, or one", Action::kStatus, chosen);
  addAction(*bridge, "arm", "Motors on, following the session", Action::kArm, chosen);
  addAction(*bridge, "disarm", "Brake, then motors off", Action::kDisarm, chosen);
  addAction(*bridge, "estop",
            "Stop all bridges, or one, for good; software, no safety-rated function",
            Action::kEstop, chosen);
  addAction(*bridge, "reset", "Forget a fault or an emergency stop; motors stay off",
            Action::kReset, chosen);
  addAction(*bridge, "home", "Find the motors' zeros: they run to their stops", Action::kHome,
            chosen);
  addBringUp(*bridge, "scan", "What answers on a port; nothing moves", "scan", chosen);
  CLI::App* config = bridge->add_subcommand("config", "Configs of hands");
  config->require_subcommand(1);
  addBringUp(*config, "make", "A config to fill in, from a hand's URDF", "make-config", chosen);
  addBringUp(*bridge, "jog", "Turn one motor slowly while the space bar is held", "jog",
             chosen);
  addBringUp(*bridge, "check", "A guided walk: directions, zeros, ranges, watchdog, stop",
             "check", chosen);
  addRecord(*bridge, chosen);
  addPlot(*bridge, chosen);
}

}  // namespace handgraft::client
