#include <fmt/format.h>

#include "client/cli/commands/commands.h"
#include "client/link/client.h"
#include "client/present/interactive_client.h"
#include "client/present/json_output.h"
#include "client/present/progress_line.h"
#include "client/present/send_model.h"
#include "core/base/error.h"
#include "idl/fields.h"

namespace handgraft::client {

namespace {

ModelFiles filesOf(const LoadOptions& options) {
  switch (options.kind) {
    case v1::MODEL_HAND:
      return handFiles(options.path, options.hand_reading, options.units);
    case v1::MODEL_OBJECT:
      return objectFiles(options.path, options.units);
    case v1::MODEL_CONTACTS:
      return contactFiles(options.path, options.object, options.contact_reading, options.units);
    case v1::MODEL_MOTION:
      return motionFiles(options.path, options.object);
  }
  rejectInput("kind {}: hand, object, contacts or motion", static_cast<int>(options.kind));
}

}  // namespace

int run(const LoadOptions& options, const CommonOptions& common, Interruption& interruption) {
  ModelFiles model = filesOf(options);
  if (!options.name.empty()) model.name = options.name;
  ProgressLine progress;
  Client server(interactiveClient(common.network, Absence::kFail, interruption, &progress));
  const v1::ModelSummary summary = ModelSender(server, interruption, !common.json).load(model);
  // What reading it brought to light: for a point cloud, how true its surface is.
  std::vector<std::string> notes;
  if (options.kind == v1::MODEL_OBJECT)
    notes = server.describe(v1::MODEL_OBJECT, summary.name(), false).get().object().notes();
  progress.clear();
  if (common.json) {
    fmt::print("{}\n", json::written(json::loaded(summary, notes)));
  } else {
    fmt::print("loaded {} {}: {}\n", nameOf(summary.kind()), summary.name(), summary.text());
    for (const std::string& note : notes)
      fmt::print("note: {}\n", quoted(note));
  }
  return 0;
}

}  // namespace handgraft::client
