#include <algorithm>
#include <chrono>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "client/cli/commands/commands.h"
#include "client/cli/commands/input_files.h"
#include "client/cli/commands/kept_session.h"
#include "client/link/client.h"
#include "client/present/export_file.h"
#include "client/present/interactive_client.h"
#include "client/present/motion_output.h"
#include "client/present/output_file.h"
#include "client/present/progress_line.h"
#include "client/present/send_model.h"
#include "core/base/error.h"

namespace handgraft::client {

namespace {

using Clock = std::chrono::steady_clock;

/// Files to send first, or nothing where the server has the model.
struct MotionInputs {
  std::optional<ModelFiles> hand;
  std::optional<ModelFiles> object;
  std::optional<ModelFiles> motion;
};

MotionInputs collectInputs(const MotionSolveOptions& options) {
  MotionInputs inputs;
  if (isPath(options.hand)) inputs.hand = handFiles(options.hand, options.hand_reading);
  if (isPath(options.object)) inputs.object = objectFiles(options.object, options.units);
  if (isPath(options.motion)) inputs.motion = motionFiles(options.motion, "");
  return inputs;
}

void checkFiles(const MotionSolveOptions& options, const MotionInputs& inputs) {
  std::vector<NamedFile> read;
  for (const auto& more : {inputsOf(inputs.hand, "--hand"), inputsOf(inputs.object, "--object"),
                           inputsOf(inputs.motion, "--motion")})
    read.insert(read.end(), more.begin(), more.end());
  std::vector<NamedFile> written = {{"--png", options.png}, {"--frames", options.frames}};
  for (const MotionFile& file : options.out)
    written.push_back({"--out", file.path});
  requireSafe(written, read);
}

/// The models by name, once they are on the server.
v1::OpenSessionRequest sessionOf(Client& server,
                                 ModelSender& sender,
                                 const MotionSolveOptions& options,
                                 MotionInputs& inputs,
                                 v1::MotionDescription& motion) {
  v1::OpenSessionRequest request;
  request.hand(nameOnServer(sender, options.hand, inputs.hand));
  if (!options.object.empty())
    request.object(nameOnServer(sender, options.object, inputs.object));
  if (inputs.motion) inputs.motion->object = request.object();
  request.motion(nameOnServer(sender, options.motion, inputs.motion));
  motion = server.describe(v1::MODEL_MOTION, request.motion(), false).get().motion();
  if (request.object().empty()) request.object(motion.object());
  return request;
}

v1::SolveMotionRequest solvingOf(const MotionSolveOptions& options, std::uint64_t session_id) {
  v1::MotionOptions how;
  how.causal(options.causal);
  how.smoothness(options.smoothness);
  how.fade_s(options.fade_s);
  how.acceleration_limit(options.acceleration_limit);
  how.solving().starts(options.starts);
  how.solving().seed(options.seed);
  v1::SolveMotionRequest request;
  request.session_id(session_id);
  request.options().push_back(how);
  return request;
}

}  // namespace

int run(const MotionSolveOptions& options,
        const CommonOptions& common,
        Interruption& interruption) {
  MotionInputs inputs = collectInputs(options);
  checkFiles(options, inputs);

  ProgressLine progress;
  Client server(interactiveClient(common.network, absenceFor(options.keep, common.network),
                                  interruption, &progress));
  const Clock::time_point begin = Clock::now();
  ModelSender sender(server, interruption, !common.json);
  MotionResult result;
  const v1::OpenSessionRequest request =
      sessionOf(server, sender, options, inputs, result.motion);
  KeptSession session(server, server.openSession(request).get());
  result.session = session.state();
  result.summary = server.solveMotion(solvingOf(options, session.id())).get();
  result.frames = framesOf(server, session.id());
  result.hand = server.describe(v1::MODEL_HAND, request.hand(), false).get().hand();
  result.total_ms = std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
  result.kept = options.keep && !server.isPrivate();
  requireConsistent(result);

  const Clock::time_point answered = Clock::now();
  OutputFiles outputs;
  for (const MotionFile& file : options.out) {
    outputs.write([&] {
      exportSession(server, session.id(), file.format, {"--out", file.path});
    });
  }
  outputs.write([&] {
    if (!options.frames.empty()) writeFile(options.frames, frameTable(result));
  });
  outputs.write([&] {
    if (!options.png.empty()) writeMotionPicture(server, options.png, result);
  });
  if (!options.out.empty() || !options.frames.empty() || !options.png.empty())
    result.files_ms =
        std::chrono::duration<double, std::milli>(Clock::now() - answered).count();
  progress.clear();
  fmt::print("{}",
             common.json ? json::written(json::motion(result)) + "\n" : text::motion(result));
  if (options.keep) session.keep(result.kept && !common.json);
  outputs.requireWritten();
  return 0;
}

}  // namespace handgraft::client
