#include <fmt/format.h>

#include "client/cli/commands/commands.h"
#include "client/link/client.h"
#include "client/present/interactive_client.h"
#include "client/present/json_output.h"
#include "client/present/progress_line.h"
#include "client/present/send_model.h"
#include "client/present/text_output.h"
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

/// What reading a model brought to light: for a point cloud, how true its surface is.
std::vector<std::string> notesOf(const v1::ModelDescription& model) {
  switch (model._d()) {
    case v1::MODEL_HAND: {
      std::vector<std::string> notes = model.hand().notes();
      // A hand's skin takes seconds, and is made when somebody needs it.
      if (model.hand().sites_found() && model.hand().sites().empty())
        notes.emplace_back(
            "it brings no contact sites: they are found on its skin when it is first used; "
            "hand "
            "inspect shows them, and what names its fingers");
      return notes;
    }
    case v1::MODEL_OBJECT:
      return model.object().notes();
    case v1::MODEL_CONTACTS:
      return model.contacts().notes();
    case v1::MODEL_MOTION:
      return model.motion().notes();
  }
  return {};
}

}  // namespace

int run(const LoadOptions& options, const CommonOptions& common, Interruption& interruption) {
  ModelFiles model = filesOf(options);
  if (!options.name.empty()) model.name = options.name;
  ProgressLine progress;
  Client server(interactiveClient(common.network, Absence::kFail, interruption, &progress));
  const v1::ModelSummary summary = ModelSender(server, interruption, !common.json).load(model);
  const std::vector<std::string> notes =
      notesOf(server.describe(options.kind, summary.name(), false).get());
  progress.clear();
  if (common.json) {
    fmt::print("{}\n", json::written(json::loaded(summary, notes)));
  } else {
    fmt::print("loaded {} {}: {}\n", nameOf(summary.kind()), summary.name(), summary.text());
    fmt::print("{}", text::notes(notes));
  }
  return 0;
}

}  // namespace handgraft::client
