#include <chrono>
#include <optional>

#include <fmt/format.h>

#include "client/cli/commands/commands.h"
#include "client/cli/commands/grasp_session.h"
#include "client/cli/commands/kept_session.h"
#include "client/link/client.h"
#include "client/link/grasp_result.h"
#include "client/present/export_file.h"
#include "client/present/interactive_client.h"
#include "client/present/interruption.h"
#include "client/present/json_output.h"
#include "client/present/minima_text.h"
#include "client/present/output_file.h"
#include "client/present/progress_line.h"
#include "client/present/send_model.h"
#include "client/present/text_output.h"
#include "core/base/error.h"

namespace handgraft::client {

namespace fs = std::filesystem;

namespace {

using Clock = std::chrono::steady_clock;

double msBetween(Clock::time_point begin, Clock::time_point end) {
  return std::chrono::duration<double, std::milli>(end - begin).count();
}

// Long work must not end in a file that cannot be written, nor in one that replaces another.
void checkFiles(const GraspOptions& options, const GraspInputs& inputs) {
  requireSafe({{"--out", options.out}, {"--png", options.png}, {"--problem", options.problem}},
              filesOf(inputs));
}

void writeProblem(Client& server,
                  const GraspOptions& options,
                  const GraspInputs& inputs,
                  const GraspResult& result) {
  const fs::path folder = fs::absolute(options.problem).parent_path();
  v1::ExportRequest request;
  request.format(v1::EXPORT_PROBLEM);
  request.session_id(result.solution.session_id());
  // The file of a mirrored hand describes the other one.
  if (inputs.hand && !result.hand.mirrored()) {
    request.urdf_path(fs::relative(fs::absolute(options.hand), folder).string());
    for (const auto& [name, directory] : inputs.hand->packages) {
      request.package_names().push_back(name);
      request.package_paths().push_back(directory.string());
    }
  } else {
    request.urdf_path(
        writeHand(result.hand, folder, {options.out, options.png, options.problem}).string());
  }
  writeFile(options.problem, server.exportSession(request).get().content);
}

// Makes one of the minima that `best` ranks the session's pose; the answer is that minimum as
// it was found, judged anew.
v1::PoseSolution chosenOf(Client& server,
                          const GraspOptions& options,
                          const v1::PoseSolution& best) {
  if (options.choose > best.minima().size()) {
    rejectInput("--choose {}: the searches ended in {} place(s)", options.choose,
                best.minima().size());
  }
  const std::uint32_t index = options.choose - 1;
  v1::EditBody body;
  v1::ChoiceEdit choice;
  choice.rank(index);
  body.choice(choice);
  server.edit(best.session_id(), best.revision(), body).get();
  v1::OptimizeRequest request;
  request.session_id(best.session_id());
  v1::PoseSolution chosen = server.optimize(request).get();
  chosen.solver(best.minima()[index].solver());
  chosen.outcome(best.outcome());
  chosen.evaluations(best.evaluations());
  chosen.minima(best.minima());
  chosen.chosen_minimum(index);
  return chosen;
}

}  // namespace

int run(const GraspOptions& options, const CommonOptions& common, Interruption& interruption) {
  // === Everything that can be wrong before a server is asked
  const Clock::time_point start = Clock::now();
  GraspInputs inputs = collectInputs(options);
  checkFiles(options, inputs);
  v1::OpenSessionRequest request = sessionRequest(options);

  ProgressLine progress;
  const Clock::time_point ready = Clock::now();
  Client server(interactiveClient(common.network, absenceFor(options.keep, common.network),
                                  interruption, &progress));
  const Clock::time_point begin = Clock::now();

  // === Models, session, transfer, solve
  ModelSender sender(server, interruption, !common.json);
  KeptSession session(server, openSession(server, sender, options, inputs, request));

  GraspResult result;
  result.server_ms = msBetween(ready, begin);
  result.models_ms = msBetween(begin, Clock::now());
  result.session = session.state();
  result.transfer = server.transfer(session.id()).get();
  v1::OptimizeRequest optimize;
  optimize.session_id(session.id());
  optimize.options().push_back(solvingOf(options));
  result.solution = server.optimize(optimize).get();
  if (options.choose > 1) result.solution = chosenOf(server, options, result.solution);
  // The solve may lay patches anew whose direction was open: what is shown is what holds now.
  const double transfer_ms = result.transfer.transfer_ms();
  result.transfer = server.transfer(session.id()).get();
  result.transfer.transfer_ms(transfer_ms);
  const v1::SessionSettings settings = server.settings(session.id()).get();
  // Others may have edited a session that is kept.
  if (settings.state().revision() == result.solution.revision())
    result.weights = settings.weights();
  result.hand =
      server.describe(v1::MODEL_HAND, request.hand(), !options.png.empty()).get().hand();
  result.object_notes =
      server.describe(v1::MODEL_OBJECT, request.object(), false).get().object().notes();
  // Whose contacts they are matters where it may be the other hand's.
  if (text::isLessThanHalfReached(result.solution)) {
    result.touched = server.describe(v1::MODEL_CONTACTS, request.contacts(), false)
                         .get()
                         .contacts()
                         .demonstrator();
  }
  const Clock::time_point end = Clock::now();
  result.total_ms = msBetween(begin, end);
  result.kept = options.keep && !server.isPrivate();
  requireConsistent(result);

  // === Results
  OutputFiles outputs;
  outputs.write([&] {
    if (!options.problem.empty()) writeProblem(server, options, inputs, result);
  });
  outputs.write([&] {
    if (!options.png.empty()) writePicture(server, options.png, result);
  });
  outputs.write([&] {
    if (!options.out.empty()) writeFile(options.out, json::written(json::grasp(result)) + "\n");
  });
  result.files_ms = msBetween(start, ready) + msBetween(end, Clock::now());
  progress.clear();
  fmt::print("{}",
             common.json ? json::written(json::grasp(result)) + "\n" : text::grasp(result));
  if (!common.json && (options.solver == "all" || options.choose > 0)) {
    fmt::print("\n{}", text::minima(result.solution, result.hand));
  }
  if (options.keep) session.keep(result.kept && !common.json);
  outputs.requireWritten();
  return 0;
}

}  // namespace handgraft::client
