#include <fmt/format.h>
#include <fmt/ranges.h>

#include "client/cli/commands/commands.h"
#include "client/cli/commands/input_files.h"
#include "client/link/pose_file.h"
#include "client/link/wire_pose.h"
#include "client/present/contacts_output.h"
#include "client/present/interactive_client.h"
#include "client/present/output_file.h"
#include "client/present/progress_line.h"
#include "client/present/send_model.h"

namespace handgraft::client {

namespace {

// The hand's links about the object, if the pose file tells where they are.
PosedLinks linksIn(const v1::HandDescription& hand,
                   const PoseFile& pose,
                   const v1::PoseContactsRequest& request) {
  const Pose X_WO = request.X_WO().empty() ? Pose::Identity() : poseOf(request.X_WO().front());
  PosedLinks posed;
  for (const v1::LinkInfo& link : hand.links()) {
    const auto X_WL = pose.links_X_WL.find(link.name());
    if (X_WL == pose.links_X_WL.end()) return {};
    posed.surfaces_L.push_back(link.surface_L());
    posed.X_OL.push_back(messageOf(X_WO.inverse() * poseOf(X_WL->second)));
  }
  return posed;
}

v1::PoseContactsRequest requestOf(const PoseContactsOptions& options, const PoseFile& pose) {
  v1::PoseContactsRequest request;
  if (!isPath(options.pose)) request.start_pose(options.pose);
  request.joints(pose.joints);
  request.joint_positions(pose.joint_rad);
  if (pose.X_WH) request.X_WH().push_back(*pose.X_WH);
  if (options.place) {
    request.X_WO().push_back(placeOf(*options.place, "--place"));
  } else if (pose.X_WO) {
    request.X_WO().push_back(*pose.X_WO);
  }
  request.reach_m(1e-3 * options.reach_mm);
  if (options.contacts != v1::ContactOptions()) request.contacts().push_back(options.contacts);
  return request;
}

// Of all that makes one set differ from another of the same hand and object.
std::string hashOf(const v1::PoseContactsRequest& request) {
  std::string text =
      fmt::format("{} {} {} {} {} {}", request.hand(), request.object(), request.start_pose(),
                  request.joints(), request.joint_positions(), request.reach_m());
  for (const auto& list : {request.X_WH(), request.X_WO()}) {
    for (const v1::Pose& X : list)
      text += fmt::format(" {} {}", X.p_m(), X.q_wxyz());
  }
  for (const v1::ContactOptions& contacts : request.contacts())
    text += " " + textOf(contacts);
  return shortHash(text);
}

}  // namespace

int run(const PoseContactsOptions& options,
        const CommonOptions& common,
        Interruption& interruption) {
  // === Everything that can be wrong before a server is asked
  std::optional<ModelFiles> hand;
  if (isPath(options.hand)) hand = handFiles(options.hand, options.reading);
  std::optional<ModelFiles> object;
  if (isPath(options.object)) object = objectFiles(options.object, options.units);
  PoseFile pose;
  std::vector<NamedFile> inputs = inputsOf(hand, "--hand");
  const std::vector<NamedFile> more = inputsOf(object, "--object");
  inputs.insert(inputs.end(), more.begin(), more.end());
  if (isPath(options.pose)) {
    pose = readPose(options.pose);
    inputs.push_back({"--pose", options.pose});
  }
  requireSafe({{"--out", options.out}, {"--png", options.png}}, inputs);
  v1::PoseContactsRequest request = requestOf(options, pose);

  ProgressLine progress;
  Client server(
      interactiveClient(common.network, Absence::kStartPrivate, interruption, &progress));
  ModelSender sender(server, interruption, !common.json);
  request.hand(nameOnServer(sender, options.hand, hand));
  request.object(nameOnServer(sender, options.object, object));
  request.name(options.name.empty()
                   ? nameFromPath(request.object() + "_" + request.hand() + ".json")
                   : options.name);
  std::string name;
  try {
    name = server.poseContacts(request).get().name();
  } catch (const Refused& refused) {
    if (refused.code() != v1::ERROR_CONFLICT || !options.name.empty()) throw;
    request.name(request.name().substr(0, 55) + "-" + hashOf(request));
    name = server.poseContacts(request).get().name();
  }

  PosedLinks posed;
  if (!options.png.empty() && !pose.links_X_WL.empty()) {
    posed = linksIn(server.describe(v1::MODEL_HAND, request.hand(), true).get().hand(), pose,
                    request);
  }
  const ContactsOutput output{options.out, options.png, common.json};
  const std::string text = outputOf(server, name, posed, output);
  progress.clear();
  fmt::print("{}", text);
  return 0;
}

}  // namespace handgraft::client
