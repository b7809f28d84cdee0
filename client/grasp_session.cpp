#include "client/grasp_session.h"

#include <algorithm>

#include "client/grasp_picture.h"
#include "client/render/png_file.h"
#include "client/wire_pose.h"
#include "core/base/error.h"

namespace handgraft::client {

namespace fs = std::filesystem;

namespace {

// False also for what is no file.
bool holds(const fs::path& path, const std::string& text) {
  std::error_code error;
  if (!fs::is_regular_file(path, error) || fs::file_size(path, error) != text.size()) {
    return false;
  }
  return text.empty() || readFile(path) == text;
}

}  // namespace

GraspInputs collectInputs(const GraspOptions& options) {
  GraspInputs inputs;
  if (isPath(options.hand)) inputs.hand = handFiles(options.hand, options.hand_reading);
  if (isPath(options.object)) inputs.object = objectFiles(options.object, options.units);
  if (isPath(options.contacts)) {
    inputs.contacts =
        contactFiles(options.contacts, "", options.contact_reading, options.units);
  }
  return inputs;
}

std::vector<NamedFile> filesOf(const GraspInputs& inputs) {
  std::vector<NamedFile> read = inputsOf(inputs.hand, "--hand");
  for (const auto& more :
       {inputsOf(inputs.object, "--object"), inputsOf(inputs.contacts, "--contacts")}) {
    read.insert(read.end(), more.begin(), more.end());
  }
  return read;
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

v1::SolveOptions solvingOf(const GraspOptions& options) {
  v1::SolveOptions solving;
  solving.solver(options.solver);
  solving.starts(options.starts);
  solving.seed(options.seed);
  solving.max_evaluations(options.max_evaluations);
  solving.paper(options.paper);
  solving.normal_form(options.normal_form);
  if (options.avoid_penetration) solving.penetration(v1::PENETRATION_AVOIDED);
  return solving;
}

v1::SessionState openSession(ServerLink& server,
                             ModelSender& sender,
                             const GraspOptions& options,
                             GraspInputs& inputs,
                             v1::OpenSessionRequest& request) {
  request.hand(nameOnServer(sender, options.hand, inputs.hand));
  request.object(nameOnServer(sender, options.object, inputs.object));
  if (inputs.contacts) {
    inputs.contacts->object = request.object();
    // A scan and its contact map come in the same units.
    if (inputs.object) inputs.contacts->units = inputs.object->units;
  }
  request.contacts(nameOnServer(sender, options.contacts, inputs.contacts));
  return server.openSession(request);
}

void writePicture(ServerLink& server, const fs::path& png, const GraspResult& result) {
  const v1::SessionState& session = result.session;
  const v1::ModelDescription object = server.describe(v1::MODEL_OBJECT, session.object(), true);
  const v1::ModelDescription contacts =
      server.describe(v1::MODEL_CONTACTS, session.contacts(), false);
  const GraspPicture picture = pictureOf(result, object.object(), contacts.contacts());
  render::writePng(png, render::renderTwoViews(picture.scene, picture.caption));
}

fs::path writeHand(const v1::HandDescription& hand,
                   const fs::path& folder,
                   const std::vector<fs::path>& taken) {
  checkModelName(hand.name(), "hand");  // it becomes a file name
  const fs::path plain = hand.name() + ".urdf";
  const fs::path hashed = fmt::format("{}-{:08x}.urdf", hand.name(),
                                      static_cast<std::uint32_t>(textHash(hand.urdf())));
  for (const fs::path& name : {plain, hashed}) {
    const fs::path path = folder / name;
    const bool is_taken = std::any_of(taken.begin(), taken.end(), [&](const fs::path& file) {
      return !file.empty() &&
             fs::absolute(file).lexically_normal() == fs::absolute(path).lexically_normal();
    });
    if (is_taken) continue;
    if (holds(path, hand.urdf())) return name;
    std::error_code error;
    if (fs::exists(fs::symlink_status(path, error))) continue;
    writeFile(path, hand.urdf());
    return name;
  }
  rejectInput("a file {} with other content is there already",
              quoted((folder / hashed).string()));
}

void exportSession(ServerLink& server,
                   std::uint64_t session_id,
                   const std::string& format,
                   const NamedFile& file) {
  requireWritable(file);
  v1::ExportRequest request;
  request.session_id(session_id);
  request.format(format);
  if (format == "problem") {
    const std::string hand = server.describeSession(session_id).hand();
    request.urdf_path(writeHand(server.describe(v1::MODEL_HAND, hand, false).hand(),
                                fs::absolute(file.path).parent_path(), {file.path})
                          .string());
  }
  writeFile(file.path, server.exportSession(request));
}

}  // namespace handgraft::client
