#include <chrono>
#include <optional>

#include <fmt/format.h>

#include "client/commands/commands.h"
#include "client/grasp_picture.h"
#include "client/grasp_result.h"
#include "client/interruption.h"
#include "client/json_output.h"
#include "client/output_file.h"
#include "client/progress_line.h"
#include "client/render/png_file.h"
#include "client/send_model.h"
#include "client/server_link.h"
#include "client/text_output.h"
#include "client/wire_pose.h"
#include "core/base/error.h"

namespace handgraft::client {

namespace fs = std::filesystem;

namespace {

using Clock = std::chrono::steady_clock;

// The three models of a grasp: files to send first, or nothing where the server has the model.
struct Inputs {
  std::optional<ModelFiles> hand;
  std::optional<ModelFiles> object;
  std::optional<ModelFiles> contacts;
};

Inputs collect(const GraspOptions& options) {
  Inputs inputs;
  if (isPath(options.hand)) inputs.hand = handFiles(options.hand, options.hand_reading);
  if (isPath(options.object)) inputs.object = objectFiles(options.object, options.units);
  if (isPath(options.contacts)) {
    inputs.contacts =
        contactFiles(options.contacts, "", options.contact_reading, options.units);
  }
  return inputs;
}

// Long work must not end in a file that cannot be written, nor in one that replaces another.
void checkFiles(const GraspOptions& options, const Inputs& inputs) {
  std::vector<NamedFile> read = inputsOf(inputs.hand, "--hand");
  for (const auto& more :
       {inputsOf(inputs.object, "--object"), inputsOf(inputs.contacts, "--contacts")}) {
    read.insert(read.end(), more.begin(), more.end());
  }
  requireSafe({{"--out", options.out}, {"--png", options.png}, {"--problem", options.problem}},
              read);
}

v1::OpenSessionRequest sessionRequest(const GraspOptions& options) {
  v1::OpenSessionRequest request;
  if (options.place) request.X_WO().push_back(placeOf(*options.place, "--place"));
  if (options.weights) {
    v1::Weights weights;
    weights.distance((*options.weights)[0]);
    weights.normal((*options.weights)[1]);
    weights.prior((*options.weights)[2]);
    request.weights().push_back(weights);
  }
  if (!options.log_map.empty() || options.interior_rings > 0) {
    v1::TransferOptions transfer;
    transfer.method(options.log_map);
    transfer.interior_rings(options.interior_rings);
    request.transfer().push_back(transfer);
  }
  return request;
}

// Closes the session however the command ends, unless it is to be kept.
class OpenSession {
 public:
  OpenSession(ServerLink& server, v1::SessionState state)
      : server_(server), state_(std::move(state)) {}

  ~OpenSession() {
    if (kept_) return;
    try {
      server_.closeSession(state_.session_id());
    } catch (const std::exception&) {
      // The reason why the command ends is the one to report; a server that is gone has closed
      // it.
    }
  }

  OpenSession(const OpenSession&) = delete;
  OpenSession& operator=(const OpenSession&) = delete;

  [[nodiscard]] const v1::SessionState& state() const { return state_; }

  [[nodiscard]] std::uint64_t id() const { return state_.session_id(); }

  void keep() { kept_ = true; }

 private:
  ServerLink& server_;
  v1::SessionState state_;
  bool kept_ = false;
};

// False also for what is no file.
bool holds(const fs::path& path, const std::string& text) {
  std::error_code error;
  if (!fs::is_regular_file(path, error) || fs::file_size(path, error) != text.size()) {
    return false;
  }
  return text.empty() || readFile(path) == text;
}

// True if an option names the file, so that it would be overwritten later.
bool isOutput(const fs::path& path, const GraspOptions& options) {
  const auto is_same = [&](const fs::path& file) {
    return !file.empty() &&
           fs::absolute(file).lexically_normal() == fs::absolute(path).lexically_normal();
  };
  return is_same(options.out) || is_same(options.png) || is_same(options.problem);
}

// Writes the hand's URDF into the folder and returns its name there. A file that others may
// need stays: then a hash of the content tells this one apart.
fs::path writeHand(const v1::HandDescription& hand,
                   const fs::path& folder,
                   const GraspOptions& options) {
  checkModelName(hand.name(), "hand");  // it becomes a file name
  const fs::path plain = hand.name() + ".urdf";
  const fs::path hashed = fmt::format("{}-{:08x}.urdf", hand.name(),
                                      static_cast<std::uint32_t>(textHash(hand.urdf())));
  for (const fs::path& name : {plain, hashed}) {
    const fs::path path = folder / name;
    if (isOutput(path, options)) continue;
    if (holds(path, hand.urdf())) return name;
    std::error_code error;
    if (fs::exists(fs::symlink_status(path, error))) continue;
    writeFile(path, hand.urdf());
    return name;
  }
  rejectInput("--problem: a file {} with other content is there already",
              quoted((folder / hashed).string()));
}

void writeProblem(ServerLink& server,
                  const GraspOptions& options,
                  const Inputs& inputs,
                  const GraspResult& result) {
  const fs::path folder = fs::absolute(options.problem).parent_path();
  v1::ExportRequest request;
  request.format("problem");
  request.session_id(result.solution.session_id());
  // The file of a mirrored hand describes the other one.
  if (inputs.hand && !result.hand.mirrored()) {
    request.urdf_path(fs::relative(fs::absolute(options.hand), folder).string());
    for (const auto& [name, directory] : inputs.hand->packages) {
      request.package_names().push_back(name);
      request.package_paths().push_back(directory.string());
    }
  } else {
    request.urdf_path(writeHand(result.hand, folder, options).string());
  }
  writeFile(options.problem, server.exportSession(request));
}

void writePicture(ServerLink& server, const GraspOptions& options, const GraspResult& result) {
  const v1::SessionState& session = result.session;
  const v1::ModelDescription object = server.describe(v1::MODEL_OBJECT, session.object(), true);
  const v1::ModelDescription contacts =
      server.describe(v1::MODEL_CONTACTS, session.contacts(), false);
  const GraspPicture picture = pictureOf(result, object.object(), contacts.contacts());
  render::writePng(options.png, render::renderTwoViews(picture.scene, picture.caption));
}

}  // namespace

int run(const GraspOptions& options, const CommonOptions& common, Interruption& interruption) {
  // === Everything that can be wrong before a server is asked
  Inputs inputs = collect(options);
  checkFiles(options, inputs);
  v1::OpenSessionRequest request = sessionRequest(options);

  ServerLink server(common.network, Absence::kStartPrivate, interruption);
  ProgressLine progress;
  server.onProgress([&](const std::string& stage, double fraction) {
    progress.show(stage, fraction);
  });
  const Clock::time_point begin = Clock::now();

  // === Models, session, transfer, solve
  ModelSender sender(server, interruption, !common.json);
  request.hand(nameOnServer(sender, options.hand, inputs.hand));
  request.object(nameOnServer(sender, options.object, inputs.object));
  if (inputs.contacts) {
    inputs.contacts->object = request.object();
    // A scan and its contact map come in the same units.
    if (inputs.object) inputs.contacts->units = inputs.object->units;
  }
  request.contacts(nameOnServer(sender, options.contacts, inputs.contacts));
  OpenSession session(server, server.openSession(request));

  GraspResult result;
  result.session = session.state();
  result.transfer = server.transfer(session.id());
  v1::OptimizeRequest optimize;
  optimize.session_id(session.id());
  v1::SolveOptions solving;
  solving.solver(options.solver);
  solving.starts(options.starts);
  solving.seed(options.seed);
  optimize.options().push_back(solving);
  result.solution = server.optimize(optimize);
  // The solve may lay patches anew whose direction was open: what is shown is what holds now.
  const double transfer_ms = result.transfer.transfer_ms();
  result.transfer = server.transfer(session.id());
  result.transfer.transfer_ms(transfer_ms);
  result.hand = server.describe(v1::MODEL_HAND, request.hand(), !options.png.empty()).hand();
  result.total_ms = std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
  result.kept = options.keep && !server.isPrivate();
  requireConsistent(result);

  // === Results
  if (!options.problem.empty()) writeProblem(server, options, inputs, result);
  if (!options.png.empty()) writePicture(server, options, result);
  if (!options.out.empty()) writeFile(options.out, json::grasp(result) + "\n");
  progress.clear();
  fmt::print("{}", common.json ? json::grasp(result) + "\n" : text::grasp(result));
  if (options.keep) {
    session.keep();
    if (result.kept && !common.json) fmt::print("session {} stays open\n", session.id());
    if (server.isPrivate()) {
      fmt::print(stderr,
                 "--keep has no effect: the session ends with the server that this "
                 "command started\n");
    }
  }
  return 0;
}

}  // namespace handgraft::client
