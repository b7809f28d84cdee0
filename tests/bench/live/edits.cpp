// handgraft-edit-bench: what an editor waits for, with a server of its own on loopback.
#include <cstdio>
#include <exception>

#include <CLI/CLI.hpp>

#include "tests/bench/live/commands.h"

int main(int argc, char** argv) {
  using namespace handgraft::bench;  // NOLINT(google-build-using-namespace): its own program
  LiveOptions options;
  CLI::App app("What an editor waits for", "handgraft-edit-bench");
  app.require_subcommand(1);
  app.fallthrough();
  app.add_option("--hand", options.hand, "URDF");
  app.add_option("--object", options.object, "mesh");
  app.add_option("--contacts", options.contacts, "contact map or set on the object");
  app.add_option("--seed", options.seed, "of the edits");
  app.add_option("--server", options.server, "arguments of the server");
  app.add_flag("--json", options.json, "one line of JSON a table");
  auto* one = app.add_subcommand("latency", "one edit after another");
  one->add_option("--edits", options.edits, "how many");
  auto* many = app.add_subcommand("crowd", "many sessions at once");
  many->add_option("--sessions", options.sessions, "how many");
  many->add_option("--rate", options.rate, "edits a second and session");
  many->add_option("--seconds", options.seconds, "how long");
  auto* wild = app.add_subcommand("flood", "10,000 edits a second on one session");
  wild->add_option("--seconds", options.seconds, "how long");
  auto* wild_edits = app.add_subcommand("pour", "the flood itself");
  wild_edits->add_option("--domain", options.domain, "of the server");
  wild_edits->add_option("--session", options.session, "to flood");
  wild_edits->add_option("--patch", options.patch, "whose weight the edits change");
  wild_edits->add_option("--rate", options.rate, "edits a second");
  wild_edits->add_option("--seconds", options.seconds, "how long");
  CLI11_PARSE(app, argc, argv);
  try {
    if (one->parsed()) latency(options);
    if (many->parsed()) crowd(options);
    if (wild->parsed()) flood(options);
    if (wild_edits->parsed()) pour(options);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "handgraft-edit-bench: %s\n", error.what());
    return 2;
  }
  return 0;
}
