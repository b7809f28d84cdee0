#include <algorithm>
#include <map>

#include <fmt/format.h>

#include "client/cli/commands/commands.h"
#include "client/cli/commands/input_files.h"
#include "client/cli/study/study_notes.h"
#include "client/cli/study/sweep_result.h"
#include "client/link/client.h"
#include "client/present/interactive_client.h"
#include "client/present/output_file.h"
#include "client/present/png_file.h"
#include "client/present/progress_line.h"
#include "client/present/send_model.h"
#include "core/base/error.h"
#include "idl/fields.h"

namespace handgraft::client {

namespace {

/// The files of each grasp, found before a server is asked.
struct GraspFiles {
  std::optional<ModelFiles> object;    ///< nothing: the server has it
  std::optional<ModelFiles> contacts;  ///< of a grasp
  std::optional<ModelFiles> motion;    ///< nothing: a grasp, or the server has it
};

GraspFiles filesOf(const StudyGrasp& grasp, const SweepOptions& options) {
  GraspFiles files;
  if (isPath(grasp.object)) files.object = objectFiles(grasp.object, options.units);
  if (grasp.isMotion()) {
    if (isPath(grasp.motion)) files.motion = motionFiles(grasp.motion, "");
    return files;
  }
  const bool is_map = grasp.contacts.extension() != ".json";
  files.contacts =
      contactFiles(grasp.contacts, "", is_map ? options.contact_reading : ContactReading(),
                   is_map ? options.units : "");
  return files;
}

v1::SweepRequest requestOf(const SweepOptions& options) {
  v1::SweepRequest request;
  for (const StudyAxis& axis : options.axes)
    request.axes().push_back(axis.axis);
  v1::SolveOptions solving;
  solving.solver(v1::enumeratorFrom<v1::Solver>(options.solver, "--solver"));
  solving.starts(options.starts);
  solving.seed(options.seed);
  request.options(solving);
  if (options.weights) {
    v1::Weights weights;
    weights.distance((*options.weights)[0]);
    weights.normal((*options.weights)[1]);
    weights.prior((*options.weights)[2]);
    request.weights().push_back(weights);
  }
  if (!options.log_map.empty()) {
    v1::TransferOptions transfer;
    transfer.method(v1::enumeratorFrom<v1::LogMapMethod>(options.log_map, "--log-map"));
    request.transfer().push_back(transfer);
  }
  return request;
}

/// Sends each file once, and asks the server for each motion's object and patches; of all that
/// a row is asked for, with `result` told which.
std::vector<v1::SweepGrasp> send(Client& server,
                                 ModelSender& sender,
                                 const std::vector<StudyGrasp>& grasps,
                                 std::vector<GraspFiles>& files,
                                 SweepResult& result) {
  std::map<std::string, std::string> sent;  // objects by path
  std::vector<v1::SweepGrasp> request;
  for (std::size_t i = 0; i < grasps.size(); ++i) {
    v1::SweepGrasp grasp;
    if (!grasps[i].object.empty()) {
      const auto known = sent.find(grasps[i].object);
      grasp.object(known != sent.end()
                       ? known->second
                       : nameOnServer(sender, grasps[i].object, files[i].object));
      sent[grasps[i].object] = grasp.object();
    }
    if (!grasps[i].isMotion()) {
      files[i].contacts->object = grasp.object();
      grasp.contacts(nameOnServer(sender, grasps[i].contacts.string(), files[i].contacts));
      request.push_back(std::move(grasp));
      result.grasps.push_back(grasps[i]);
      continue;
    }
    if (files[i].motion) files[i].motion->object = grasp.object();
    grasp.motion(nameOnServer(sender, grasps[i].motion, files[i].motion));
    const v1::MotionDescription motion =
        server.describe(v1::MODEL_MOTION, grasp.motion(), false).get().motion();
    if (grasp.object().empty()) grasp.object(motion.object());
    for (const StudyGrasp& row : withPatches(grasps[i], motion.patches())) {
      grasp.contacts(row.patch);
      request.push_back(grasp);
      result.grasps.push_back(row);
    }
  }
  return request;
}

/// Units of the axes: angles, travels of sliders, or none. Errors: InvalidInput for degrees of
/// a slider.
std::vector<std::string> unitsOf(const std::vector<StudyAxis>& axes,
                                 const v1::HandDescription& hand) {
  std::vector<std::string> units;
  for (const StudyAxis& axis : axes) {
    const bool is_limit = axis.axis.property() == v1::PROPERTY_LOWER ||
                          axis.axis.property() == v1::PROPERTY_UPPER;
    const bool slides = std::any_of(
        hand.joints().begin(), hand.joints().end(), [&](const v1::JointInfo& joint) {
          return joint.name() == axis.axis.target() && joint.kind() == v1::JOINT_PRISMATIC;
        });
    if (is_limit && slides && axis.in_degrees)
      rejectInput("{}: the joint slides; its limits are in m", quoted(axis.name));
    units.emplace_back(!is_limit ? "" : slides ? "m" : axis.in_degrees ? "deg" : "rad");
  }
  return units;
}

/// What is known of the grasps, and was said of them; of motions only what was said.
std::vector<StudyContacts> contactsOf(Client& server,
                                      const v1::SweepRequest& request,
                                      const SweepResult& result) {
  std::vector<StudyContacts> contacts;
  for (std::size_t i = 0; i < result.grasps.size(); ++i) {
    StudyContacts one{result.grasps[i].label, {}};
    if (!result.grasps[i].isMotion()) {
      const std::string& name = request.grasps()[i].contacts();
      one.described = server.describe(v1::MODEL_CONTACTS, name, false).get().contacts();
    }
    for (const v1::SweepNote& note : result.reply.notes())
      if (note.grasp() == i) one.dealt.push_back(note.text());
    contacts.push_back(std::move(one));
  }
  return contacts;
}

}  // namespace

int run(const SweepOptions& options, const CommonOptions& common, Interruption& interruption) {
  // === Everything that can be wrong before a server is asked
  const FoundGrasps found = findGrasps(options.folders);
  for (const SkippedFile& skipped : found.skipped)
    fmt::print(stderr, "skipped {}: {}\n", quoted(skipped.path.string()), skipped.reason);
  std::optional<ModelFiles> hand;
  if (isPath(options.hand)) hand = handFiles(options.hand, options.hand_reading);
  std::vector<NamedFile> read = inputsOf(hand, "--hand");
  std::vector<GraspFiles> files;
  for (const StudyGrasp& grasp : found.grasps) {
    files.push_back(filesOf(grasp, options));
    for (const auto& more : {inputsOf(files.back().object, "--object"),
                             inputsOf(files.back().contacts, "--contacts-dir"),
                             inputsOf(files.back().motion, "--motion")})
      read.insert(read.end(), more.begin(), more.end());
  }
  requireSafe({{"--out", options.out}, {"--png", options.png}}, read);
  v1::SweepRequest request = requestOf(options);

  ProgressLine progress;
  Client server(
      interactiveClient(common.network, Absence::kStartPrivate, interruption, &progress));
  ModelSender sender(server, interruption, !common.json);
  request.hand(nameOnServer(sender, options.hand, hand));

  SweepResult result;
  result.hand = request.hand();
  result.axes = options.axes;
  const v1::HandDescription described =
      server.describe(v1::MODEL_HAND, request.hand(), false).get().hand();
  result.units = unitsOf(options.axes, described);
  request.grasps(send(server, sender, found.grasps, files, result));
  result.reply = server.sweep(request).get();
  requireConsistent(result);
  // By now the hand's skin is made, and with it is known which side's hand it is.
  result.notes = notesOn(server.describe(v1::MODEL_HAND, request.hand(), false).get().hand(),
                         contactsOf(server, request, result));
  for (const std::string& note : notesOn(options.axes, described))
    result.notes.push_back(note);

  // === Results
  if (!options.out.empty()) writeFile(options.out, csvOf(result));
  if (!options.png.empty()) writePng(options.png, pictureOf(result));
  progress.clear();
  fmt::print("{}", common.json ? json::sweep(result) + "\n" : text::sweep(result));
  return 0;
}

}  // namespace handgraft::client
