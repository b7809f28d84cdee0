#include <cstdio>
#include <exception>
#include <string>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include "core/base/error.h"

#include "tests/bench/baseline.h"
#include "tests/bench/chain.h"
#include "tests/bench/drags.h"
#include "tests/bench/import.h"
#include "tests/bench/logmap.h"
#include "tests/bench/logmap_accuracy.h"
#include "tests/bench/logmap_speed.h"
#include "tests/bench/motions/motions.h"
#include "tests/bench/retargeting/retargeting.h"
#include "tests/bench/scaling.h"
#include "tests/bench/solve.h"
#include "tests/bench/survey.h"
#include "tests/bench/thin_walls.h"
#include "tests/bench/transfer_speed.h"

namespace {

constexpr int kFailed = 1;
constexpr int kWrongInput = 2;

int complain(const std::string& message, int code) {
  std::fprintf(stderr, "handgraft-bench: %s\n", message.c_str());
  return code;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Measures Handgraft's numerical core", "handgraft-bench");
  app.require_subcommand(0, 1);
  handgraft::bench::addChainCommand(app);
  handgraft::bench::addThinWallsCommand(app);
  handgraft::bench::addDragsCommand(app);
  handgraft::bench::addImportCommand(app);
  handgraft::bench::addBaselineCommand(app);
  handgraft::bench::addLogMapCommand(app);
  handgraft::bench::addLogMapAccuracyCommand(app);
  handgraft::bench::addLogMapSpeedCommand(app);
  handgraft::bench::addMotionsCommand(app);
  handgraft::bench::addPairsCommand(app);
  handgraft::bench::addPlacementsCommand(app);
  handgraft::bench::addRetargetingCommand(app);
  handgraft::bench::addScalingCommand(app);
  handgraft::bench::addSolveCommand(app);
  handgraft::bench::addSolversCommand(app);
  handgraft::bench::addSurveyCommand(app);
  handgraft::bench::addTablesCommand(app);
  handgraft::bench::addTransferCommand(app);
  try {
    app.parse(argc, argv);
    if (!app.get_subcommands().empty()) return 0;
    return complain(
        "a command is missing; there are: baseline chain drags import logmap logmap-accuracy "
        "logmap-speed motions pairs placements retargeting scaling solve solvers survey "
        "tables thin-walls transfer",
        kWrongInput);
  } catch (const CLI::Success& help) {
    return app.exit(help);
  } catch (const CLI::ParseError& error) {
    return complain(error.what(), kWrongInput);
  } catch (const handgraft::InvalidInput& error) {
    return complain(error.what(), kWrongInput);
  } catch (const std::exception& error) {
    return complain(error.what(), kFailed);
  }
}
