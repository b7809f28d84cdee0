#include <algorithm>
#include <memory>

#include <CLI/CLI.hpp>

#include "client/cli/options/command_options.h"
#include "client/cli/options/grasp_flags.h"
#include "client/cli/options/option_checks.h"
#include "client/present/export_file.h"
#include "core/base/error.h"

namespace handgraft::client {

namespace {

struct ParsedEdit {
  GraspFlags flags;
  std::uint64_t session_id = 0;
  std::string script;
  double at_s = 0.0;
  double falloff_s = 0.0;
};

void addEdit(CLI::App& app, CommandOptions& chosen) {
  const auto parsed = std::make_shared<ParsedEdit>();
  CLI::App* command =
      app.add_subcommand("edit", "Edit a session live: at a prompt, from a script or a pipe");
  CLI::Option* session =
      command
          ->add_option(
              "session", parsed->session_id,
              "Its id, or the first digits of it, at least four; or open one by --hand ...")
          ->check(objectionToCount);
  parsed->flags.addTo(*command);
  command->add_option("--script", parsed->script, "Run the commands of a file")
      ->check(objectionToFile);
  CLI::Option* at = command->add_option(
      "--at", parsed->at_s, "Edit the session's motion at that time (s), as `at` does");
  CLI::Option* falloff = command->add_option("--falloff", parsed->falloff_s,
                                             "Fading over so many seconds before and after it");
  falloff->needs(at);
  command->footer(
      "At the prompt help lists the commands, Tab completes, ? explains. A script or a pipe "
      "ends at the first command that fails.");
  command->callback([parsed, session, at, &chosen] {
    EditOptions edit;
    if (at->count() > 0) edit.at_s = parsed->at_s;
    edit.falloff_s = parsed->falloff_s;
    if (session->count() > 0) {
      if (parsed->flags.named()) {
        rejectInput("edit {}: --hand, --object and --contacts open another session",
                    parsed->session_id);
      }
      parsed->flags.requireUnused("opening a session");
      if (parsed->session_id == 0) rejectInput("edit 0: sessions count from 1");
      edit.session_id = parsed->session_id;
    } else {
      if (!parsed->flags.named()) {
        rejectInput(
            "edit: a session's id must follow (handgraft sessions lists them), or "
            "--hand, --object and --contacts, which open one");
      }
      edit.grasp = parsed->flags.grasp();
    }
    edit.script = parsed->script;
    chosen = edit;
  });
}

void addSessionId(CLI::App& command, std::uint64_t& session_id) {
  command.add_option("session", session_id, "Its id, or the first digits of it, at least four")
      ->required()
      ->check(objectionToCount);
}

void addExport(CLI::App& app, CommandOptions& chosen) {
  struct Parsed {
    ExportOptions options;
    std::string out;
  };

  const auto parsed = std::make_shared<Parsed>();
  CLI::App* command =
      app.add_subcommand("export", "Write a session's last solution for other programs");
  addSessionId(*command, parsed->options.session_id);
  // The page is the client's own.
  const std::string formats = fmt::format("{}, html", fmt::join(exportFormats(), ", "));
  command
      ->add_option("--format", parsed->options.format,
                   formats + " (motions have no obj, isaac_grasp and problem)")
      ->required();
  command->add_option("--out", parsed->out, "The file")->required()->check(objectionToFile);
  command->callback([parsed, formats, &chosen] {
    const std::string& format = parsed->options.format;
    const std::vector<std::string>& known = exportFormats();
    if (format != "html" && std::find(known.begin(), known.end(), format) == known.end())
      rejectInput("--format {}: there are {}", quoted(format), formats);
    parsed->options.out = parsed->out;
    chosen = parsed->options;
  });
}

CLI::Option* addFile(CLI::App& command, std::string& file) {
  return command.add_option("file", file, "handgraft-session/1")
      ->required()
      ->check(objectionToFile);
}

void addShare(CLI::App& session, CommandOptions& chosen) {
  const auto parsed = std::make_shared<ShareOptions>();
  CLI::App* share =
      session.add_subcommand("share", "Say who else may edit a session, in a secured domain");
  addSessionId(*share, parsed->session_id);
  share
      ->add_option("with", parsed->with,
                   "Identities, in place of those before; everyone; nobody")
      ->required();
  share->add_option("--owner", parsed->owner, "An identity to hand the session to");
  share->callback([parsed, &chosen] {
    chosen = *parsed;
  });
  share->fallthrough();
}

void addSessionFiles(CLI::App& app, CommandOptions& chosen) {
  CLI::App* session = app.add_subcommand("session", "Sessions in files, and for others");
  session->require_subcommand(1);
  addShare(*session, chosen);

  struct Parsed {
    std::uint64_t session_id = 0;
    std::string file;
    std::string out;
  };

  const auto parsed = std::make_shared<Parsed>();
  CLI::App* save =
      session->add_subcommand("save", "Write all of a session: state, history, snapshots, log");
  addSessionId(*save, parsed->session_id);
  addFile(*save, parsed->file);
  save->callback([parsed, &chosen] {
    chosen = SaveOptions{parsed->session_id, parsed->file};
  });
  CLI::App* load = session->add_subcommand("load", "Open a session of such a file");
  addFile(*load, parsed->file);
  load->callback([parsed, &chosen] {
    chosen = OpenFileOptions{parsed->file};
  });
  CLI::App* replay =
      session->add_subcommand("replay", "Play its log again and say whether it ends the same");
  addFile(*replay, parsed->file);
  replay->add_option("--out", parsed->out, "Write what it came to")->check(objectionToFile);
  replay->callback([parsed, &chosen] {
    chosen = ReplayOptions{parsed->file, parsed->out};
  });
  for (CLI::App* command : {save, load, replay})
    command->fallthrough();
}

}  // namespace

void addEditorCommands(CLI::App& app, CommandOptions& chosen) {
  addEdit(app, chosen);
  addExport(app, chosen);
  addSessionFiles(app, chosen);
}

}  // namespace handgraft::client
