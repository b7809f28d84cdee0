#include <map>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "client/cli/commands/commands.h"
#include "client/cli/commands/input_files.h"
#include "client/link/client.h"
#include "client/present/interactive_client.h"
#include "client/present/json_output.h"
#include "client/present/motion_output.h"
#include "client/present/output_file.h"
#include "client/present/progress_line.h"
#include "client/present/send_model.h"
#include "core/base/error.h"

namespace handgraft::client {

namespace {

constexpr const char* kFirstUri = "first.json";
constexpr const char* kLastUri = "last.json";
constexpr const char* kPathUri = "path.csv";
constexpr const char* kRecordingUri = "recording.json";
constexpr const char* kObjectPathUri = "object.smexp";

v1::MotionDescription describedMotion(Client& server, const std::string& name, bool with_file) {
  return server.describe(v1::MODEL_MOTION, name, with_file).get().motion();
}

void print(const v1::MotionDescription& motion, bool as_json) {
  v1::ModelDescription description;
  description.motion(motion);
  fmt::print("{}", as_json ? json::written(json::description(description)) + "\n"
                           : text::motion(motion));
}

/// A contact set as a file of the upload: the user's own, or what the server says of its own.
UploadFile contactSetOf(Client& server, const std::string& contacts, const char* uri) {
  if (isPath(contacts)) return {uri, contacts};
  const v1::ContactsDescription set =
      server.describe(v1::MODEL_CONTACTS, contacts, false).get().contacts();
  if (set.file().empty())
    rejectInput("contacts {} lie on a point cloud, whose places no file can name", contacts);
  return {uri, {}, set.file()};
}

/// The object that a file names; empty where it does not.
std::string objectIn(const std::filesystem::path& path) {
  const json::Json file = json::Json::parse(readFile(path), nullptr, false);
  if (!file.is_object() || !file.contains("object") || !file["object"].is_string()) return "";
  return file["object"].get<std::string>();
}

/// A recording may say of which mesh it is, which is not what the server calls it.
void requireObjectNamed(const std::filesystem::path& recording) {
  const json::Json file = json::Json::parse(readFile(recording), nullptr, false);
  if (!file.is_object() || file.contains("object")) return;
  const auto mesh = file.find("object_mesh");
  if (mesh == file.end() || !mesh->is_string()) return;
  rejectInput(
      "{}: its object_mesh is {}; say by --object which mesh that is, or what the server calls "
      "it",
      quoted(recording.string()), quoted(mesh->get<std::string>()));
}

/// What a contact set says that it lies on; empty where it does not.
std::string objectUnder(Client& server, const std::string& contacts) {
  if (isPath(contacts)) return objectIn(contacts);
  return server.describe(v1::MODEL_CONTACTS, contacts, false).get().contacts().object();
}

/// Points of one object mean nothing on another. Whoever names the object himself knows better
/// than a file.
void requireOneObject(Client& server, const MotionImportOptions& options) {
  if (!options.object.empty() && (isPath(options.first) || isPath(options.last))) return;
  const std::string first = objectUnder(server, options.first);
  const std::string last = objectUnder(server, options.last);
  if (first.empty() || last.empty() || first == last) return;
  rejectInput("contacts {} lie on object {} and {} on {}: a motion is of one object",
              quoted(options.first), quoted(first), quoted(options.last), quoted(last));
}

/// The object that is meant where none is named: that of the grasps, or of what a hand did.
std::string objectOf(Client& server, const MotionImportOptions& options) {
  if (!options.hand.empty()) return objectIn(options.recording);
  for (const std::string& contacts : {options.first, options.last}) {
    if (contacts.empty() || isPath(contacts)) continue;
    return server.describe(v1::MODEL_CONTACTS, contacts, false).get().contacts().object();
  }
  return "";
}

ModelFiles joinedFiles(Client& server, const MotionImportOptions& options) {
  json::Json plan = {{"format", "handgraft-motion-plan/1"},
                     {"name", options.name},
                     {"first", kFirstUri},
                     {"path", kPathUri}};
  std::vector<UploadFile> files = {contactSetOf(server, options.first, kFirstUri),
                                   {kPathUri, options.path}};
  if (options.last != options.first) {
    plan["last"] = kLastUri;
    files.push_back(contactSetOf(server, options.last, kLastUri));
  }
  const std::pair<const char*, std::optional<double>> numbers[] = {
      {"rate_hz", options.rate_hz},
      {"slide_begin_share", options.slide_begin},
      {"slide_end_share", options.slide_end},
      {"vanish_share", options.vanish},
      {"appear_share", options.appear}};
  for (const auto& [name, number] : numbers)
    if (number) plan[name] = *number;
  return plannedMotion(options.name, json::written(plan), std::move(files));
}

ModelFiles recordedFiles(const MotionImportOptions& options) {
  if (options.object_path.empty()) {
    ModelFiles files = motionFiles(options.recording, "");
    files.name = options.name;
    return files;
  }
  const json::Json plan = {{"format", "handgraft-motion-plan/1"},
                           {"name", options.name},
                           {"recording", kRecordingUri},
                           {"object_path", kObjectPathUri}};
  return plannedMotion(
      options.name, json::written(plan),
      {{kRecordingUri, options.recording}, {kObjectPathUri, options.object_path}});
}

ModelFiles trajectoryFiles(const MotionImportOptions& options, const std::string& hand) {
  // By its own name, which complaints tell; the plan has one, too.
  const std::string uri = "did/" + options.recording.filename().string();
  json::Json plan = {{"format", "handgraft-motion-plan/1"},
                     {"name", options.name},
                     {"hand", hand},
                     {"hand_trajectory", uri}};
  if (options.reach_m) plan["reach_m"] = *options.reach_m;
  if (options.every_s) plan["every_s"] = *options.every_s;
  return plannedMotion(options.name, json::written(plan), {{uri, options.recording}});
}

std::vector<NamedFile> inputsOf(const MotionImportOptions& options) {
  std::vector<NamedFile> inputs;
  if (!options.recording.empty()) inputs.push_back({"recording", options.recording});
  if (!options.object_path.empty()) inputs.push_back({"--object-path", options.object_path});
  if (!options.path.empty()) inputs.push_back({"--path", options.path});
  if (isPath(options.first)) inputs.push_back({"first", options.first});
  if (isPath(options.last)) inputs.push_back({"last", options.last});
  return inputs;
}

}  // namespace

int run(const MotionShowOptions& options,
        const CommonOptions& common,
        Interruption& interruption) {
  std::optional<ModelFiles> motion;
  std::optional<ModelFiles> object;
  if (isPath(options.motion)) motion = motionFiles(options.motion, "");
  if (isPath(options.object)) object = objectFiles(options.object, options.units);
  ProgressLine progress;
  const Absence absence = motion ? Absence::kStartPrivate : Absence::kFail;
  Client server(interactiveClient(common.network, absence, interruption, &progress));
  ModelSender sender(server, interruption, !common.json);
  if (motion && !options.object.empty())
    motion->object = nameOnServer(sender, options.object, object);
  const std::string name = nameOnServer(sender, options.motion, motion);
  const v1::MotionDescription described = describedMotion(server, name, false);
  progress.clear();
  print(described, common.json);
  return 0;
}

int run(const MotionImportOptions& options,
        const CommonOptions& common,
        Interruption& interruption) {
  std::optional<ModelFiles> object;
  if (isPath(options.object)) object = objectFiles(options.object, options.units);
  std::optional<ModelFiles> hand;
  if (isPath(options.hand)) hand = handFiles(options.hand, options.hand_reading);
  std::vector<NamedFile> inputs = inputsOf(options);
  for (const auto& more : {inputsOf(object, "--object"), inputsOf(hand, "--hand")})
    inputs.insert(inputs.end(), more.begin(), more.end());
  requireSafe({{"--out", options.out}}, inputs);
  if (!options.recording.empty() && options.object.empty())
    requireObjectNamed(options.recording);

  ProgressLine progress;
  Client server(
      interactiveClient(common.network, Absence::kStartPrivate, interruption, &progress));
  ModelSender sender(server, interruption, !common.json);
  if (options.recording.empty()) requireOneObject(server, options);
  ModelFiles files = options.recording.empty() ? joinedFiles(server, options)
                     : options.hand.empty()
                         ? recordedFiles(options)
                         : trajectoryFiles(options, nameOnServer(sender, options.hand, hand));
  files.object = options.object.empty() ? objectOf(server, options)
                                        : nameOnServer(sender, options.object, object);
  const std::string name = sender.import(files, options.is_named);
  const v1::MotionDescription motion = describedMotion(server, name, !options.out.empty());
  if (!options.out.empty()) writeFile(options.out, motion.file());
  progress.clear();
  print(motion, common.json);
  if (!options.out.empty() && !common.json)
    fmt::print("\nwrote {}\n", quoted(options.out.string()));
  return 0;
}

}  // namespace handgraft::client
