#include <memory>

#include <CLI/CLI.hpp>

#include "client/cli/options/command_options.h"
#include "client/cli/options/grasp_flags.h"
#include "client/cli/options/option_checks.h"
#include "core/base/error.h"

namespace handgraft::client {

namespace {

struct ParsedView {
  GraspFlags flags;
  ViewOptions options;
  std::string shown;  ///< a session's id, or a file of one
  bool no_browser = false;
};

bool isNumber(const std::string& text) {
  return !text.empty() && text.find_first_not_of("0123456789") == std::string::npos;
}

ViewOptions viewOf(const ParsedView& parsed) {
  ViewOptions view = parsed.options;
  view.open_browser = !parsed.no_browser;
  if (!parsed.shown.empty()) {
    if (parsed.flags.named()) {
      rejectInput("view {}: --hand, --object and --contacts open another session",
                  quoted(parsed.shown));
    }
    if (isNumber(parsed.shown)) {
      if (const std::string objection = objectionToCount(parsed.shown); !objection.empty())
        rejectInput("view {}", objection);
      view.session_id = std::stoull(parsed.shown);
      if (view.session_id == 0) rejectInput("view 0: sessions count from 1");
    } else {
      view.file = parsed.shown;
    }
  }
  if (parsed.flags.named()) {
    view.grasp = parsed.flags.grasp();
  } else {
    parsed.flags.requireUnused("opening a session");
  }
  return view;
}

}  // namespace

void addViewCommand(CLI::App& app, CommandOptions& chosen) {
  const auto parsed = std::make_shared<ParsedView>();
  CLI::App* command =
      app.add_subcommand("view", "Show sessions as a page in the browser, to see and to edit");
  command->add_option(
      "session", parsed->shown,
      "A session's id, or a file of one; or open one by --hand ...; or neither");
  parsed->flags.addTo(*command);
  command
      ->add_option("--address", parsed->options.address,
                   "Where to serve it; not of this machine alone: links hold a token")
      ->capture_default_str();
  command->add_option("--port", parsed->options.port, "0: any that is free")
      ->capture_default_str();
  command->add_flag("--read-only", parsed->options.read_only, "Nobody edits");
  command->add_flag("--no-browser", parsed->no_browser, "Print the link alone");
  command->callback([parsed, &chosen] {
    chosen = viewOf(*parsed);
  });
}

}  // namespace handgraft::client
