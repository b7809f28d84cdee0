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
#include "client/server_link.h"
#include "client/text_output.h"
#include "core/base/error.h"
#include "core/base/pose.h"

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
  if (isPath(options.hand)) inputs.hand = handFiles(options.hand, options.packages);
  if (isPath(options.object)) inputs.object = objectFiles(options.object);
  if (isPath(options.contacts)) inputs.contacts = contactFiles(options.contacts, "");
  return inputs;
}

// Long work must not end in a file that cannot be written, nor in one that replaces another.
void checkFiles(const GraspOptions& options, const Inputs& inputs) {
  std::vector<NamedFile> files;
  for (const NamedFile& file :
       {NamedFile{"--out", options.out}, NamedFile{"--png", options.png},
        NamedFile{"--problem", options.problem}}) {
    if (file.path.empty()) continue;
    requireWritable(file);
    files.push_back(file);
  }
  for (const auto& [option, model] :
       {std::pair("--hand", &inputs.hand), std::pair("--object", &inputs.object),
        std::pair("--contacts", &inputs.contacts)}) {
    if (!model->has_value()) continue;
    for (const NamedFile& file : files) {
      requireDistinct({file, {option, (*model)->files.front().path}});
    }
  }
  requireDistinct(files);
}

// The name under which the server has the model afterwards. Another model of that name may be
// there; then this one is told apart by a hash of its content.
std::string send(ServerLink& server, ModelFiles model) {
  try {
    return server.load(model).name();
  } catch (const idl::cyclone::Refused& refused) {
    if (refused.code() != v1::ERROR_CONFLICT) throw;
  }
  model.name = fmt::format("{}-{:08x}", model.name.substr(0, 55),
                           static_cast<std::uint32_t>(contentHash(model)));
  return server.load(model).name();
}

v1::Pose placeOf(const std::array<double, 7>& numbers) {
  const handgraft::Pose X_WO =
      poseFromQuaternion({numbers[0], numbers[1], numbers[2]},
                         {numbers[3], numbers[4], numbers[5], numbers[6]}, "--place");
  const Eigen::Vector4d q = quaternionOf(X_WO);
  v1::Pose pose;
  pose.p_m() = {numbers[0], numbers[1], numbers[2]};
  pose.q_wxyz() = {q[0], q[1], q[2], q[3]};
  return pose;
}

v1::OpenSessionRequest sessionRequest(const GraspOptions& options) {
  v1::OpenSessionRequest request;
  if (options.place) request.X_WO().push_back(placeOf(*options.place));
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
  v1::ExportProblemRequest request;
  request.session_id(result.solution.session_id());
  if (inputs.hand) {
    request.urdf_path(fs::relative(fs::absolute(options.hand), folder).string());
    for (const auto& [name, directory] : inputs.hand->packages) {
      request.package_names().push_back(name);
      request.package_paths().push_back(directory.string());
    }
  } else {
    request.urdf_path(writeHand(result.hand, folder, options).string());
  }
  writeFile(options.problem, server.exportProblem(request));
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
  const Inputs inputs = collect(options);
  checkFiles(options, inputs);
  v1::OpenSessionRequest request = sessionRequest(options);

  ServerLink server(common.network, Absence::kStartPrivate, interruption);
  ProgressLine progress;
  server.onProgress([&](const std::string& stage, double fraction) {
    progress.show(stage, fraction);
  });
  const Clock::time_point begin = Clock::now();

  // === Models, session, transfer, solve
  request.hand(inputs.hand ? send(server, *inputs.hand) : options.hand);
  request.object(inputs.object ? send(server, *inputs.object) : options.object);
  if (inputs.contacts) {
    ModelFiles contacts = *inputs.contacts;
    contacts.object = request.object();
    request.contacts(send(server, contacts));
  } else {
    request.contacts(options.contacts);
  }
  OpenSession session(server, server.openSession(request));

  GraspResult result;
  result.session = session.state();
  result.transfer = server.transfer(session.id());
  v1::OptimizeRequest optimize;
  optimize.session_id(session.id());
  optimize.solver(options.solver);
  optimize.starts(options.starts);
  optimize.seed(options.seed);
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
